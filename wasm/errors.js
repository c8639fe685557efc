// What goes wrong, as one type: see index.d.ts.

/**
 * @typedef {import('./index.d.ts').SlicerError} SlicerErrorApi
 * @implements {SlicerErrorApi}
 */
export class SlicerError extends Error {
  /** @param {import('./index.d.ts').SlicerErrorFields} fields */
  constructor({ kind, code, stage, message, hint, places }) {
    super(message);
    /** @type {'SlicerError'} */
    this.name = 'SlicerError';
    this.kind = kind;
    this.code = code;
    this.stage = stage;
    this.hint = hint;
    this.places = places;
  }
  toJSON() {
    const { kind, code, stage, message, hint, places } = this;
    return { kind, code, stage, message, hint, places };
  }
  /** @param {import('./index.d.ts').SlicerErrorFields} fields */
  static from(fields) {
    return new SlicerError(fields);
  }
}

/**
 * A method was called wrongly.
 * @param {string} message
 */
export function usageError(message) {
  return new SlicerError({ kind: 'engine', code: 'engine.usage', stage: null, message, hint: '', places: [] });
}
