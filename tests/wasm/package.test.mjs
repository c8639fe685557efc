// What users install: packed, installed into an empty folder, used from Node in five lines.
import test from 'node:test';
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { leaningBlock, root } from './leaning_block.mjs';

test('the packed package slices in an empty folder', () => {
  const folder = mkdtempSync(join(tmpdir(), 's3package-'));
  try {
    const npm = (...args) => execFileSync('npm', args, { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
    const [{ filename, files }] = JSON.parse(npm('pack', join(root, 'wasm'), '--json', '--ignore-scripts'));
    const paths = files.map(({ path }) => path);
    for (const path of ['index.js', 'index.d.ts', 'README.md', 'dist/s3slicer.mjs', 'dist/s3slicer.wasm', 'dist/s3slicer-threads.mjs', 'dist/s3slicer-threads.wasm', 'dist/s3slicer-threads.worker.js'])
      assert.ok(paths.includes(path), path);
    assert.ok(paths.every((path) => !/\.(cpp|txt)$/.test(path)), paths.join(' '));
    writeFileSync(join(folder, 'package.json'), '{"type": "module"}');
    npm('install', '--offline', '--no-audit', '--no-fund', filename);
    writeFileSync(join(folder, 'block.tet'), leaningBlock());
    // The five lines of the README.
    const lines = /```js\n([^`]*)```/.exec(readFileSync(join(root, 'wasm', 'README.md'), 'utf8'))[1];
    assert.equal(lines.trim().split('\n').filter((line) => !line.startsWith('import')).length, 5, lines);
    writeFileSync(join(folder, 'slice.js'), lines.replaceAll('part.stl', 'block.tet'));
    execFileSync(process.execPath, ['slice.js'], { cwd: folder });
    assert.match(readFileSync(join(folder, 'program.gcode'), 'utf8'), /\nG1 /);
    // And one wrong input.
    writeFileSync(join(folder, 'block.tet'), 'nothing');
    assert.throws(() => execFileSync(process.execPath, ['slice.js'], { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'] }), (error) => /SlicerError.*block\.tet/s.test(String(error.stderr)));
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('each artefact is small enough for a page', () => {
  for (const name of ['s3slicer', 's3slicer-threads']) {
    const size = gzipSync(readFileSync(join(root, 'wasm', 'dist', `${name}.wasm`)), { level: 9 }).length;
    assert.ok(size < 1.5e6, `${name}.wasm has ${size} bytes compressed`);
  }
});
