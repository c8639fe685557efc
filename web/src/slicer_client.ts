// The worker as promises. A worker that dies rejects its calls with `engine.crashed`; the next start() makes a new one.
import type { Progress, SlicerErrorFields, StageInfo } from '../../wasm/index.js';
import { aliveLock } from './protocol.ts';
import type { CallName, Calls, EngineInfo, FromWorker, ResultName, Results, ToWorker } from './protocol.ts';
import type { Which } from '../../wasm/index.js';

/** What the page needs of a Worker; tests give their own. */
export interface WorkerLike {
  postMessage(message: ToWorker, transfer?: Transferable[]): void;
  terminate(): void;
  onmessage: ((event: MessageEvent<FromWorker>) => void) | null;
  onerror: ((event: ErrorEvent) => void) | null;
}

/** What went wrong, for people: what, where, what to do. */
export class SliceError extends Error {
  readonly kind: SlicerErrorFields['kind'];
  readonly code: string;
  readonly stage: SlicerErrorFields['stage'];
  readonly hint: string;
  readonly places: SlicerErrorFields['places'];
  constructor(fields: SlicerErrorFields) {
    super(fields.message);
    this.kind = fields.kind;
    this.code = fields.code;
    this.stage = fields.stage;
    this.hint = fields.hint;
    this.places = fields.places;
  }
}

export interface ClientEvents {
  onProgress(progress: Progress, memoryBytes: number): void;
  onStages(stages: StageInfo[]): void;
  /** The worker died by itself. Its calls are rejected already. */
  onCrash(error: SliceError): void;
}

type Answer<Name extends CallName> = ReturnType<Calls[Name]>;
interface Waiting {
  resolve(value: unknown): void;
  reject(error: SliceError): void;
}

export class SlicerClient {
  #makeWorker: (name: string) => WorkerLike;
  #events: ClientEvents;
  #worker: WorkerLike | null = null;
  #waiting = new Map<number, Waiting>();
  #lastId = 0;
  #generation = 0;
  #cancelFlag: Uint8Array | null = null;
  #lastStage: SlicerErrorFields['stage'] = null;

  constructor(makeWorker: (name: string) => WorkerLike, events: ClientEvents) {
    this.#makeWorker = makeWorker;
    this.#events = events;
  }

  /** A fresh worker with a fresh engine; a former one is ended and its calls are rejected as cancelled. */
  async start(options: { engineUrl: string; threads?: number }): Promise<EngineInfo> {
    this.stop();
    const generation = ++this.#generation;
    const name = `${Date.now().toString(36)}-${generation}`;
    const worker = this.#makeWorker(name);
    this.#worker = worker;
    worker.onmessage = (event) => this.#receive(generation, event.data);
    worker.onerror = (event) => {
      event.preventDefault?.();
      this.#crash(generation, event.message || 'The worker stopped');
    };
    const info = await this.call('start', options);
    this.#cancelFlag = info.cancelFlag;
    this.#watch(generation, name);
    return info;
  }

  call<Name extends CallName>(
    name: Name, ...[argument]: Parameters<Calls[Name]>
  ): Promise<Answer<Name>> {
    const id = ++this.#lastId;
    return new Promise<unknown>((resolve, reject) => {
      if (!this.#worker) {
        reject(crashed('The engine is not running', this.#lastStage));
        return;
      }
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ type: 'call', id, name, argument });
    }) as Promise<Answer<Name>>;
  }

  result<Name extends ResultName>(name: Name, which?: Which): Promise<Results[Name] | null> {
    return this.call('result', which ? { name, which } : { name }) as Promise<Results[Name] | null>;
  }

  /** Asks the run to end: at the next checkpoint where memory is shared, else before the next stage. */
  cancel(): void {
    if (this.#cancelFlag) Atomics.store(this.#cancelFlag, 0, 1);
    this.#worker?.postMessage({ type: 'cancel' });
  }

  /** Whether a running stage hears a cancel. */
  get cancelsWithinStage(): boolean {
    return this.#cancelFlag !== null;
  }

  /** Ends the worker at once. Results in it are lost. */
  stop(): void {
    this.#worker?.terminate();
    this.#forget({
      kind: 'cancelled', code: 'cancelled', stage: this.#lastStage, message: 'Cancelled', hint: '', places: [],
    });
  }

  #receive(generation: number, message: FromWorker): void {
    if (generation !== this.#generation) return;
    switch (message.type) {
      case 'progress':
        this.#lastStage = message.progress.stage;
        this.#events.onProgress(message.progress, message.memoryBytes);
        break;
      case 'stages':
        this.#events.onStages(message.stages);
        break;
      case 'answer':
        this.#take(message.id)?.resolve(message.value);
        break;
      case 'failure':
        if (message.error.code === 'engine.crashed') {
          this.#crash(generation, message.error.message, message.error.hint);
        } else {
          this.#take(message.id)?.reject(new SliceError(message.error));
        }
        break;
    }
  }

  #take(id: number): Waiting | undefined {
    const waiting = this.#waiting.get(id);
    this.#waiting.delete(id);
    return waiting;
  }

  /** Waits for the lock that the worker holds: having it means that the worker is gone. */
  #watch(generation: number, name: string): void {
    if (typeof navigator === 'undefined' || !navigator.locks) return;
    void navigator.locks.request(aliveLock(name), () => this.#crash(generation, 'The worker was ended from outside'));
  }

  #crash(generation: number, message: string, hint?: string): void {
    if (generation !== this.#generation || !this.#worker) return;
    const error = crashed(message, this.#lastStage, hint);
    this.#worker.terminate();
    this.#forget(error);
    this.#events.onCrash(error);
  }

  #forget(error: SlicerErrorFields): void {
    this.#worker = null;
    this.#cancelFlag = null;
    const waiting = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const one of waiting) one.reject(error instanceof SliceError ? error : new SliceError(error));
  }
}

function crashed(message: string, stage: SlicerErrorFields['stage'], hint = ''): SliceError {
  return new SliceError({
    kind: 'engine',
    code: 'engine.crashed',
    stage,
    message: `The slicing engine stopped${stage ? ` in stage ${stage}` : ''}: ${message}.`,
    hint: hint || 'Model and settings are kept. Slice again; with fewer tets if memory ran out.',
    places: [],
  });
}
