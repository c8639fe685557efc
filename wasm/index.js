// S³ Slicer for JavaScript: loads the WebAssembly module and wraps its classes. The API is described in index.d.ts.
import { SlicerError, usageError } from './errors.js';
import { packProject, unpackProject, writeZip } from './project.js';

export { SlicerError, writeZip };

export const pathKinds = Object.freeze(/** @type {const} */ (['wall', 'infill', 'gap_fill']));

const isNode = typeof (/** @type {any} */ (globalThis).process)?.versions?.node === 'string';
const MOST_THREADS = 16;
const PAGE = 65536;
const INITIAL_MEMORY = 64 * 1024 * 1024;
const MAXIMUM_MEMORY = 65536 * PAGE;

/** @type {typeof import('./index.d.ts').threadsAvailable} */
export function threadsAvailable() {
  return typeof SharedArrayBuffer === 'function' && (isNode || globalThis.crossOriginIsolated === true);
}

/** @type {typeof import('./index.d.ts').load} */
export async function load(options = {}) {
  const threads = await threadCount(options.threads);
  const name = threads > 1 ? 's3slicer-threads' : 's3slicer';
  const base = new URL(options.baseUrl ?? './dist/', options.baseUrl === undefined ? import.meta.url : pageAddress());
  const memory =
    options.memory ??
    new WebAssembly.Memory({ initial: INITIAL_MEMORY / PAGE, maximum: MAXIMUM_MEMORY / PAGE, shared: threads > 1 });
  const script = new URL(`${name}.mjs`, base).href;
  let started = () => {};
  try {
    const wasmBinary = options.wasmBinary ?? (isNode ? await readLocalFile(new URL(`${name}.wasm`, base)) : undefined);
    if (isNode && threads > 1) started = (await nodeModule('./node_threads.js')).pretendWorker();
    const { default: create } = await import(/* webpackIgnore: true */ /* @vite-ignore */ script);
    const module = await create({
      wasmMemory: memory,
      wasmBinary,
      mainScriptUrlOrBlob: script,
      locateFile: (/** @type {string} */ file) => new URL(file, base).href,
      s3Threads: threads,
    });
    return new Engine(module, memory, threads);
  } catch (error) {
    throw new SlicerError({
      kind: 'engine',
      code: 'engine.load',
      stage: null,
      message: `The engine could not be loaded from ${base.href}: ${messageOf(error)}`,
      hint: 'Check that the folder is served with the .wasm file in it, and that the browser knows WebAssembly with exceptions',
      places: [],
    });
  } finally {
    started();
  }
}

/** @param {number | undefined} wanted */
async function threadCount(wanted) {
  if (wanted !== undefined && !(Number.isInteger(wanted) && wanted >= 1 && wanted <= MOST_THREADS))
    throw usageError(`threads is ${wanted}, not a whole number from 1 to ${MOST_THREADS}`);
  if (wanted !== undefined && wanted > 1 && !threadsAvailable())
    throw usageError('There are no threads here: the page is not cross-origin isolated');
  if (wanted !== undefined) return wanted;
  if (!threadsAvailable()) return 1;
  const processors = isNode ? (await nodeModule('node:os')).availableParallelism() : navigator.hardwareConcurrency;
  return Math.max(1, Math.min(processors || 1, MOST_THREADS));
}

/** @param {URL} url */
async function readLocalFile(url) {
  if (url.protocol !== 'file:') return undefined;
  return (await nodeModule('node:fs/promises')).readFile(url);
}

/**
 * What exists in Node only: hidden from bundlers.
 * @param {string} name
 */
function nodeModule(name) {
  return import(/* webpackIgnore: true */ /* @vite-ignore */ name);
}

function pageAddress() {
  return globalThis.document?.baseURI ?? globalThis.location?.href ?? import.meta.url;
}

/** @param {unknown} error */
function messageOf(error) {
  return error instanceof Error ? error.message : String(error);
}

/**
 * @param {import('./index.d.ts').Bytes} bytes
 * @param {string} what
 */
function asBytes(bytes, what) {
  if (bytes instanceof Uint8Array) return bytes;
  if (bytes instanceof ArrayBuffer) return new Uint8Array(bytes);
  throw usageError(`${what} must be given as Uint8Array or ArrayBuffer`);
}

/**
 * @param {unknown} value
 * @param {string} what
 */
function asText(value, what) {
  if (typeof value !== 'string') throw usageError(`${what} must be a string`);
  return value;
}

/** @param {import('./index.d.ts').Bytes | string | object} json */
function bytesOfJson(json) {
  if (json instanceof Uint8Array || json instanceof ArrayBuffer) return asBytes(json, 'JSON');
  return new TextEncoder().encode(typeof json === 'string' ? json : JSON.stringify(json));
}

/**
 * Dotted keys as nested objects.
 * @param {import('./index.d.ts').Params} params
 */
function nested(params) {
  if (params === null || typeof params !== 'object') throw usageError('Parameters are given as an object');
  /** @type {Record<string, any>} */
  const result = Object.create(null);  // where "__proto__" is a key like any other
  for (const [key, value] of Object.entries(params)) {
    const path = key.split('.');
    const last = /** @type {string} */ (path.pop());
    let at = result;
    for (const name of path) at = at[name] ??= Object.create(null);
    const isGroup = value !== null && typeof value === 'object';
    at[last] = isGroup ? Object.assign(at[last] ?? Object.create(null), nested(value)) : value;
  }
  return result;
}

const yieldToEvents = () => new Promise((resolve) => setTimeout(resolve, 0));

/**
 * @typedef {import('./index.d.ts').Engine} EngineApi
 * @implements {EngineApi}
 */
class Engine {
  #module;
  #memory;
  #native;
  #flag;
  #disposed = false;
  #crashed = false;
  #slicers = new Set();

  /**
   * @param {any} module
   * @param {WebAssembly.Memory} memory
   * @param {number} threads
   */
  constructor(module, memory, threads) {
    this.#module = module;
    this.#memory = memory;
    this.threads = threads;
    this.#native = new module.Engine(threads);
    // It lies in the memory that the threads share; this buffer stays valid when the memory grows.
    this.#flag = threads > 1 ? new Uint8Array(memory.buffer, this.#native.cancelAddress(), 1) : null;
    this.version = module.version();
  }

  get crashed() {
    return this.#crashed;
  }
  get memoryBytes() {
    return this.#memory.buffer.byteLength;
  }
  get memoryUsed() {
    return this.call(() => this.#module.memoryUsed());
  }
  get cancelFlag() {
    return this.#flag;
  }

  createSlicer() {
    const slicer = new Slicer(this, this.call(() => new this.#module.Slicer(this.#native)));
    this.#slicers.add(slicer);
    return slicer;
  }
  /** @param {Slicer} slicer */
  forget(slicer) {
    this.#slicers.delete(slicer);
  }
  schema() {
    return JSON.parse(this.call(() => this.#module.schema()));
  }
  machines() {
    return this.call(() => this.#module.machineNames());
  }
  /** @param {string} name */
  machineProfile(name) {
    return this.call(() => this.#module.machineProfile(asText(name, 'The name')));
  }
  /**
   * @param {import('./index.d.ts').Bytes} bytes
   * @param {string} fileName
   */
  inspect(bytes, fileName) {
    const [array, name] = [asBytes(bytes, 'The model'), asText(fileName, 'The file name')];
    return this.call(() => this.#native.inspect(array, name));
  }

  cancel() {
    if (this.#disposed || this.#crashed) return;
    this.#native.setCancel(true);
  }
  clearCancel() {
    if (this.#disposed || this.#crashed) return;
    this.#native.setCancel(false);
  }

  /**
   * Calls into the module: unwraps {value} and throws {error}. What else comes out of it is a trap.
   * @param {() => any} call
   * @returns {any}
   */
  call(call) {
    if (this.#disposed) throw usageError('The engine was disposed of');
    if (this.#crashed) throw crash('The engine has crashed before');
    let result;
    try {
      result = call();
    } catch (error) {
      if (error instanceof SlicerError) throw error;
      this.#crashed = true;
      throw crash(`The engine has crashed: ${messageOf(error)}`);
    }
    if (result?.error) {
      const error = SlicerError.from(result.error);
      if (error.kind === 'cancelled') this.clearCancel();
      if (error.kind === 'engine') this.#crashed = true;
      throw error;
    }
    return result && Object.hasOwn(result, 'value') ? result.value : result;
  }

  dispose() {
    if (this.#disposed) return;
    if (!this.#crashed) {
      for (const slicer of [...this.#slicers]) slicer.dispose();
      this.#native.delete();
    }
    this.#disposed = true;
    this.#module.PThread?.terminateAllThreads();
    this.#module = this.#native = null;
  }
}

/** @param {string} message */
function crash(message) {
  return new SlicerError({
    kind: 'engine',
    code: 'engine.crashed',
    stage: null,
    message,
    hint: 'Load the engine again and give it model and settings; with fewer tets (mesh.target_tets) if memory ran out',
    places: [],
  });
}

/**
 * @typedef {import('./index.d.ts').Slicer} SlicerApi
 * @implements {SlicerApi}
 */
class Slicer {
  #engine;
  #native;
  /** @type {Map<string, string>} */
  #profiles = new Map();

  /**
   * @param {Engine} engine
   * @param {any} native
   */
  constructor(engine, native) {
    this.#engine = engine;
    this.#native = native;
  }

  /** @param {(native: any) => unknown} call */
  #call(call) {
    if (this.#native === null) throw usageError('The slicer was disposed of');
    return this.#engine.call(() => call(this.#native));
  }

  /**
   * Sets or, with null, takes away a file that a parameter names.
   * @param {'setStress' | 'setLoadCase' | 'setCriticalRegion' | 'setSurfaceRegion'} setter
   * @param {Uint8Array | null} bytes
   * @param {string} fileName
   */
  #setFile(setter, bytes, fileName) {
    const name = bytes === null ? '' : asText(fileName, 'The file name');
    this.#call((native) => native[setter](bytes ?? new Uint8Array(0), name));
  }

  /**
   * @param {import('./index.d.ts').Bytes} bytes
   * @param {string} fileName
   */
  setModel(bytes, fileName) {
    const [array, name] = [asBytes(bytes, 'The model'), asText(fileName, 'The file name')];
    this.#call((native) => native.setModel(array, name));
  }
  /**
   * @param {import('./index.d.ts').Bytes | null} bytes
   * @param {string} [fileName]
   */
  setStress(bytes, fileName = 'stress.csv') {
    this.#setFile('setStress', bytes === null ? null : asBytes(bytes, 'The stress'), fileName);
  }
  /**
   * @param {import('./index.d.ts').Bytes | string | object | null} loadCase
   * @param {string} [fileName]
   */
  setLoadCase(loadCase, fileName = 'loads.json') {
    this.#setFile('setLoadCase', loadCase === null ? null : bytesOfJson(loadCase), fileName);
  }
  /**
   * @param {import('./index.d.ts').Bytes | string | object | null} region
   * @param {string} [fileName]
   */
  setCriticalRegion(region, fileName = 'critical.json') {
    this.#setFile('setCriticalRegion', region === null ? null : bytesOfJson(region), fileName);
  }
  /**
   * @param {import('./index.d.ts').Bytes | string | object | null} region
   * @param {string} [fileName]
   */
  setSurfaceRegion(region, fileName = 'surface.json') {
    this.#setFile('setSurfaceRegion', region === null ? null : bytesOfJson(region), fileName);
  }
  /** @param {import('./index.d.ts').Params} params */
  setParams(params) {
    const json = JSON.stringify(nested(params));
    this.#call((native) => native.setParams(json, false));
  }
  resetParams(params = {}) {
    const json = JSON.stringify(nested(params));
    this.#call((native) => native.setParams(json, true));
  }
  /**
   * @param {string} name
   * @param {string | object} profile
   */
  setMachineProfile(name, profile) {
    const text = typeof profile === 'string' ? profile : JSON.stringify(profile);
    this.#call((native) => native.setMachineProfile(asText(name, 'The name'), text));
    this.#profiles.set(name, text);
  }

  givenParams() {
    return this.#call((native) => native.givenParams());
  }
  params() {
    return this.#call((native) => native.params());
  }
  schema() {
    return this.#engine.schema();
  }
  inputFiles() {
    return this.#call((native) => native.inputFiles());
  }
  inspect() {
    return this.#call((native) => native.inspect());
  }

  stages() {
    return this.#call((native) => native.stages());
  }
  /** @param {import('./index.d.ts').OnProgress} [onProgress] */
  advance(onProgress) {
    /** @type {{error: unknown} | null} */
    let thrown = null;
    const report = (/** @type {import('./index.d.ts').Step} */ stage, /** @type {number} */ fraction) => {
      if (thrown) return;
      try {
        onProgress?.({ stage, fraction });
      } catch (error) {  // must not pass through the module
        thrown = { error };
        this.#engine.cancel();
      }
    };
    try {
      return this.#call((native) => native.advance(onProgress ? report : null));
    } catch (error) {
      throw thrown ? /** @type {{error: unknown}} */ (thrown).error : error;
    }
  }
  /** @param {import('./index.d.ts').RunOptions} [options] */
  async run(options) {
    await this.runTo('metrics', options);
  }
  /**
   * @param {import('./index.d.ts').Stage} last
   * @param {import('./index.d.ts').RunOptions} [options]
   */
  async runTo(last, { onProgress, onStage } = {}) {
    const names = this.stages().map((/** @type {import('./index.d.ts').StageInfo} */ info) => info.stage);
    if (!names.includes(last)) throw usageError(`There is no stage "${last}"; there are ${names.join(', ')}`);
    const end = names.indexOf(last) + 1;
    this.clearCancel();
    for (;;) {
      if (this.stages().slice(0, end).every((/** @type {import('./index.d.ts').StageInfo} */ info) => info.state === 'done')) return;
      const { stage } = this.advance(onProgress);
      onStage?.(this.stages()[names.indexOf(stage)]);
      await yieldToEvents();
    }
  }
  cancel() {
    this.#engine.cancel();
  }
  clearCancel() {
    this.#engine.clearCancel();
  }
  get cancelFlag() {
    return this.#engine.cancelFlag;
  }

  fileSurface() {
    return this.#call((native) => native.fileSurface());
  }
  placement() {
    return this.#call((native) => native.placement());
  }
  surface({ precision = 32 } = {}) {
    return this.#call((native) => native.surface(precision));
  }
  tets({ precision = 32 } = {}) {
    return this.#call((native) => native.tets(precision));
  }
  stress({ precision = 32 } = {}) {
    return this.#call((native) => native.stress(precision));
  }
  faces({ precision = 32 } = {}) {
    return this.#call((native) => native.faces(precision));
  }
  deformation({ precision = 32 } = {}) {
    return this.#call((native) => native.deformation(precision));
  }
  faceAngles({ which = 'curved', precision = 32 } = {}) {
    return this.#call((native) => native.faceAngles(isPlanar(which), precision));
  }
  histogramData({ which = 'curved', precision = 32 } = {}) {
    return this.#call((native) => native.histogramData(isPlanar(which), precision));
  }
  gouging({ precision = 32 } = {}) {
    return this.#call((native) => native.gouging(precision));
  }
  layers({ which = 'curved', precision = 32 } = {}) {
    return this.#call((native) => native.layers(isPlanar(which), precision));
  }
  waypoints({ which = 'curved', precision = 32 } = {}) {
    return this.#call((native) => native.waypoints(isPlanar(which), precision));
  }
  motion({ precision = 32 } = {}) {
    return this.#call((native) => native.motion(precision));
  }
  metrics() {
    return this.#call((native) => native.metrics());
  }
  report() {
    return JSON.parse(new TextDecoder().decode(this.exportFile('report.json')));
  }
  plots() {
    return this.#call((native) => native.plots());
  }

  listExports() {
    return this.#call((native) => native.listExports());
  }
  /** @param {string} name */
  exportFile(name) {
    return this.#call((native) => native.exportFile(asText(name, 'The name')));
  }

  saveProject(extra = null) {
    const params = this.givenParams();
    const files = this.inputFiles();
    if (files.model === null) throw usageError('A project needs a model');
    return packProject({
      params,
      ...files,
      machine: this.#profiles.get(params.machine) ?? null,
      extra,
    });
  }
  /** @param {import('./index.d.ts').Bytes} bytes */
  openProject(bytes) {
    const project = unpackProject(asBytes(bytes, 'The project'));
    // A load case and its material are checked first: a project that cannot be taken changes nothing but these.
    if (project.machine !== null) this.setMachineProfile(project.params.machine, project.machine);
    this.setLoadCase(project.loadCase?.bytes ?? null, project.loadCase?.name);
    this.setStress(project.stress?.bytes ?? null, project.stress?.name);
    this.setCriticalRegion(project.criticalRegion?.bytes ?? null, project.criticalRegion?.name);
    this.setSurfaceRegion(project.surfaceRegion?.bytes ?? null, project.surfaceRegion?.name);
    this.setModel(project.model.bytes, project.model.name);
    this.resetParams(project.params);
    return project.extra;
  }

  dispose() {
    if (this.#native === null) return;
    if (!this.#engine.crashed) this.#native.delete();
    this.#engine.forget(this);
    this.#native = null;
  }
}

/** @param {string} which */
function isPlanar(which) {
  if (which !== 'curved' && which !== 'planar') throw usageError(`which is "${which}", not curved or planar`);
  return which === 'planar';
}
