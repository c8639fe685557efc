// Cancels from another thread, through the flag that a multi-threaded engine shares.
import { Worker } from 'node:worker_threads';

/**
 * A thread that sets the flag some ms after it was told to.
 * @param {Int32Array} flag  Slicer.cancelFlag
 * @returns {Promise<{in: (ms: number) => void, since: () => number | null, end: () => Promise<number>}>} `since`: ms since
 * the last cancel was given, null before that
 */
export async function canceller(flag) {
  const noted = new Float64Array(new SharedArrayBuffer(8));
  const source = `const { flag, noted } = require('node:worker_threads').workerData;
    require('node:worker_threads').parentPort.on('message', (delay) => setTimeout(() => {
      noted[0] = Date.now();
      Atomics.store(flag, 0, 1);
    }, delay));`;
  const worker = new Worker(source, { eval: true, workerData: { flag, noted } });
  await new Promise((resolve) => worker.once('online', resolve));
  return {
    in: (ms) => {
      noted[0] = 0;
      worker.postMessage(ms);
    },
    since: () => (noted[0] > 0 ? Date.now() - noted[0] : null),
    end: () => worker.terminate(),
  };
}
