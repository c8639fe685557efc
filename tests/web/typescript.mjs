// Modules of the browser app for Node: TypeScript bundled to one module in memory.
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

const require = createRequire(new URL('../../web/package.json', import.meta.url));

/** @param {string} name  of a file in web/src */
export async function load(name) {
  const { build } = require('esbuild');
  const result = await build({
    entryPoints: [fileURLToPath(new URL(`../../web/src/${name}`, import.meta.url))],
    bundle: true, format: 'esm', platform: 'neutral', write: false, logLevel: 'error',
  });
  return import(`data:text/javascript;base64,${Buffer.from(result.outputFiles[0].contents).toString('base64')}`);
}
