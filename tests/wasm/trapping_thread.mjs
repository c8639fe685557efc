// A thread of the engine whose calls from JavaScript trap once a flag is set: see trap_in_thread.mjs.
import { getEnvironmentData } from 'node:worker_threads';

const trap = getEnvironmentData('trap');
// (module (func (export "t") unreachable))
const bytes = [0, 0x61, 0x73, 0x6d, 1, 0, 0, 0, 1, 4, 1, 0x60, 0, 0, 3, 2, 1, 0, 7, 5, 1, 1, 0x74, 0, 0, 10, 5, 1, 3, 0, 0, 0x0b];
const unreachable = new WebAssembly.Instance(new WebAssembly.Module(new Uint8Array(bytes))).exports.t;
const get = WebAssembly.Table.prototype.get;
WebAssembly.Table.prototype.get = function (index) {
  const entry = get.call(this, index);
  return (...values) => {
    if (Atomics.load(trap, 0)) unreachable();
    return entry(...values);
  };
};
await import('../../wasm/node_thread_main.js');
