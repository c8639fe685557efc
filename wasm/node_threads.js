// Threads in Node: a Worker as browsers have it, over node:worker_threads, for the module's own start-up of threads.
import { Worker as NodeThread } from 'node:worker_threads';

/** @type {Set<NodeThread>} */
const starting = new Set();

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

/** Makes the class known where there is none. */
export function provide() {
  const scope = /** @type {any} */ (globalThis);
  scope.Worker ??= NodeWorker;
}

/** Threads that have started must not keep the process alive. */
export function letGo() {
  for (const thread of starting) thread.unref();
  starting.clear();
}
