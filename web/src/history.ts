// Undo and redo over immutable snapshots.
export class History<State> {
  #past: State[] = [];
  #future: State[] = [];
  #present: State;
  #lastKey = '';
  static readonly LIMIT = 200;

  constructor(initial: State) {
    this.#present = initial;
  }

  get present(): State {
    return this.#present;
  }
  get canUndo(): boolean {
    return this.#past.length > 0;
  }
  get canRedo(): boolean {
    return this.#future.length > 0;
  }

  /** Steps with the same key, one after the other, become one: a slider that is dragged. */
  push(next: State, key = ''): void {
    if (key === '' || key !== this.#lastKey) {
      this.#past.push(this.#present);
      if (this.#past.length > History.LIMIT) this.#past.shift();
    }
    this.#lastKey = key;
    this.#present = next;
    this.#future = [];
  }

  /** The next push starts a step of its own. */
  seal(): void {
    this.#lastKey = '';
  }

  undo(): State {
    const before = this.#past.pop();
    if (before !== undefined) {
      this.#future.push(this.#present);
      this.#present = before;
    }
    this.seal();
    return this.#present;
  }

  redo(): State {
    const after = this.#future.pop();
    if (after !== undefined) {
      this.#past.push(this.#present);
      this.#present = after;
    }
    this.seal();
    return this.#present;
  }

  /** Forgets everything but the given state. */
  reset(state: State): void {
    this.#past = [];
    this.#future = [];
    this.#present = state;
    this.seal();
  }
}
