// Where a thread begins in Node: what the module's script for workers expects to find in a browser.
import { parentPort, workerData } from 'node:worker_threads';

const scope = /** @type {any} */ (globalThis);
const port = /** @type {import('node:worker_threads').MessagePort} */ (parentPort);
scope.self = globalThis;
scope.location = { href: workerData };
scope.importScripts = () => {};  // its presence says that this is a worker
scope.postMessage = (/** @type {any} */ message) => port.postMessage(message);

const started = import(workerData);
port.on('message', async (data) => {
  await started;
  scope.onmessage({ data });
});
