// Threads in Node: a Worker as browsers have it, over node:worker_threads, for the module's own start-up of threads.
import { Worker as NodeThread } from 'node:worker_threads';

/** @type {Set<NodeThread>} */
const starting = new Set();
/** How many modules are starting, and what was added to the global scope for them. */
let pretending = 0;
/** @type {string[]} */
let added = [];

class NodeWorker {
  #thread;
  /** @type {((event: {data: any}) => void) | undefined} */
  onmessage;
  /** @type {((error: Error) => void) | undefined} */
  onerror;

  /** @param {string | URL} url */
  constructor(url) {
    this.#thread = new NodeThread(new URL('./node_thread_main.js', import.meta.url), { workerData: String(url) });
    this.#thread.on('message', (data) => this.onmessage?.({ data }));
    this.#thread.on('error', (error) => this.onerror?.(error));
    starting.add(this.#thread);
  }
  /**
   * @param {any} message
   * @param {any[]} [transfer]
   */
  postMessage(message, transfer) {
    this.#thread.postMessage(message, transfer);
  }
  terminate() {
    this.#thread.terminate();
  }
}

/**
 * While the module starts, it finds what it takes for a worker of a browser: there alone it may wait for its threads
 * without spinning.
 * @returns {() => void}  takes it away again; threads that have started do not keep the process alive from then on
 */
export function pretendWorker() {
  const scope = /** @type {any} */ (globalThis);
  if (pretending++ === 0) {
    const pretended = { Worker: NodeWorker, importScripts() {}, self: globalThis, location: { href: import.meta.url } };
    added = Object.keys(pretended).filter((name) => !(name in scope));
    for (const name of added) scope[name] = /** @type {any} */ (pretended)[name];
  }
  return () => {
    if (--pretending > 0) return;
    for (const name of added) delete scope[name];
    for (const thread of starting) thread.unref();
    starting.clear();
  };
}
