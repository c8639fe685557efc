// Lets a thread of the pool trap while the caller waits for it, and prints what arrives. A program of its own: where it
// goes wrong, the caller waits for ever.
import { Worker as NodeThread, setEnvironmentData } from 'node:worker_threads';
import { load } from '../../wasm/index.js';
import { leaningBlock } from './leaning_block.mjs';

const trap = new Int32Array(new SharedArrayBuffer(4));
setEnvironmentData('trap', trap);
globalThis.Worker = class {
  #thread;
  constructor(url) {
    this.#thread = new NodeThread(new URL('./trapping_thread.mjs', import.meta.url), { workerData: String(url) });
    this.#thread.on('message', (data) => this.onmessage?.({ data }));
  }
  postMessage(message, transfer) {
    this.#thread.postMessage(message, transfer);
  }
  terminate() {
    this.#thread.terminate();
  }
};
const engine = await load({ threads: 2 });
const slicer = engine.createSlicer();
slicer.setModel(leaningBlock(), 'block.tet');
await slicer.runTo('objectives');
Atomics.store(trap, 0, 1);
try {
  await slicer.run();
  console.log(JSON.stringify({ code: 'nothing was thrown' }));
} catch (error) {
  console.log(JSON.stringify({ ...error.toJSON(), crashed: engine.crashed }));
}
engine.dispose();
