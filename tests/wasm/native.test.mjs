// The same .tet file through the native program and through WebAssembly.
import test from 'node:test';
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { load } from '../../wasm/index.js';
import { leaningBlock, root } from './leaning_block.mjs';

/** Vertices (x y z nx ny nz thickness) and triangles of a layer's file. */
function readLayer(bytes) {
  const text = new TextDecoder('latin1').decode(bytes);
  const end = text.indexOf('end_header\n') + 'end_header\n'.length;
  const count = (name) => Number(new RegExp(`element ${name} (\\d+)`).exec(text)[1]);
  const view = new DataView(bytes.buffer, bytes.byteOffset + end);
  const [rows, faces] = [count('vertex'), count('face')];
  const vertices = Array.from({ length: 7 * rows }, (_, i) => view.getFloat64(8 * i, true));
  const start = 7 * 8 * rows;
  const triangles = Array.from({ length: faces }, (_, f) => [1, 5, 9].map((k) => view.getInt32(start + 13 * f + k, true)));
  return { header: text.slice(0, end), vertices, triangles };
}

function largestDifference(a, b) {
  assert.equal(a.length, b.length);
  return a.reduce((worst, value, i) => Math.max(worst, Math.abs(value - b[i])), 0);
}

/** Every number of a report's part, with its place. */
function* numbers(value, place = '') {
  if (typeof value === 'number') yield [place, value];
  else if (value !== null && typeof value === 'object')
    for (const [key, inner] of Object.entries(value)) yield* numbers(inner, `${place}.${key}`);
}

/**
 * Layers of an upright block need nothing but arithmetic. Those of a leaning one come from sines and arc cosines, whose last digits
 * differ between libraries, and a hundred iterations in which such differences grow: 2e-8 mm were seen.
 */
const blocks = [
  { name: 'an upright block', lean: 0, bound: 1e-9 },
  { name: 'a leaning block', lean: 1.2, bound: 1e-6 },
];

for (const [threads, { name, lean, bound }] of [1, 2].flatMap((n) => blocks.map((block) => [n, block])))
  test(`layers and figures of ${name} with ${threads} thread(s) are those of the native program`, async () => {
    const folder = mkdtempSync(join(tmpdir(), 's3native-'));
    const block = leaningBlock([6, 5, 8], [12, 10, 16], 0.6, lean);
    writeFileSync(join(folder, 'block.tet'), block);
    try {
      const out = join(folder, 'out');
      execFileSync(join(root, 'build', 'native', 's3slice'), ['run', join(folder, 'block.tet'), '-o', out, '--quiet', '--threads', '1', '--nozzle.diameter', '1.5']);
      const engine = await load({ threads });
      const slicer = engine.createSlicer();
      slicer.setModel(block, 'block.tet');
      slicer.setParams({ 'nozzle.diameter': 1.5 });
      await slicer.run();

      const files = readdirSync(join(out, 'layers')).sort();
      assert.deepEqual(slicer.listExports().map(({ name }) => name).filter((name) => name.startsWith('layers/')), files.map((file) => `layers/${file}`));
      let worst = 0;
      for (const file of files) {
        const native = readLayer(readFileSync(join(out, 'layers', file)));
        const here = readLayer(slicer.exportFile(`layers/${file}`));
        assert.deepEqual(here.triangles, native.triangles, file);
        worst = Math.max(worst, largestDifference(here.vertices, native.vertices));
      }
      assert.ok(worst <= bound, `layers differ by ${worst}`);

      const native = JSON.parse(readFileSync(join(out, 'report.json'), 'utf8'));
      const here = slicer.report();
      for (const key of ['curved', 'planar', 'mesh', 'pi_rad', 'outer_iterations']) {
        const expected = new Map(numbers(native[key]));
        const found = new Map(numbers(here[key]));
        assert.deepEqual([...found.keys()], [...expected.keys()], key);
        for (const [place, value] of found)
          assert.ok(Math.abs(value - expected.get(place)) <= 1e-6 * Math.max(1, Math.abs(value)), `${key}${place}: ${value} and ${expected.get(place)}`);
      }
      engine.dispose();
    } finally {
      rmSync(folder, { recursive: true });
    }
  });
