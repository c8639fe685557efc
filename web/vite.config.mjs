// Builds the static page into dist/: the app, the engine of wasm/dist under a name by its content, the bundled models.
import { createHash } from 'node:crypto';
import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { defineConfig } from 'vite';

const here = fileURLToPath(new URL('.', import.meta.url));
const engine = join(here, '../wasm/dist'), models = join(here, '../models'), out = join(here, 'dist');

function digest(files) {
  const hash = createHash('sha256');
  for (const file of files) hash.update(readFileSync(file));
  return hash.digest('hex').slice(0, 10);
}

function filesIn(folder) {
  return readdirSync(folder).sort().map((name) => join(folder, name)).flatMap((path) => (statSync(path).isDirectory() ? filesIn(path) : [path]));
}

const engineFiles = existsSync(engine) ? filesIn(engine) : [];
const engineFolder = `engine-${digest(engineFiles)}/`;

/** Engine, examples, and the service worker's list of what the page itself is; the rest is kept once it was used. */
function bundle() {
  return {
    name: 's3-bundle',
    apply: 'build',
    closeBundle() {
      if (engineFiles.length > 0) cpSync(engine, join(out, engineFolder), { recursive: true });
      mkdirSync(join(out, 'examples'), { recursive: true });
      for (const name of readdirSync(models)) {
        if (name.endsWith('.stl')) writeFileSync(join(out, 'examples', `${name}.gz`), gzipSync(readFileSync(join(models, name)), { level: 9 }));
        if (name.endsWith('.json')) cpSync(join(models, name), join(out, 'examples', name));
      }
      const files = filesIn(out).filter((file) => !file.endsWith('sw.js'));
      const names = files.map((file) => file.slice(out.length + 1)).filter((name) => name !== 'index.html' && !name.startsWith('engine-') && !/examples\/.*\.(gz|json)$/.test(name));
      const worker = join(out, 'sw.js');
      writeFileSync(worker, readFileSync(worker, 'utf8').replace('__VERSION__', digest(files)).replace('__FILES__', JSON.stringify(['./', ...names])));
    },
  };
}

export default defineConfig({
  root: here,
  base: './',
  define: { __ENGINE__: JSON.stringify(engineFolder) },
  worker: { format: 'es' },
  build: { outDir: out, emptyOutDir: true, target: 'es2022', chunkSizeWarningLimit: 900, modulePreload: { polyfill: false } },
  plugins: [bundle()],
});
