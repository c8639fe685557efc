// Memory grows when it must, and does not when the same is done again.
import test from 'node:test';
import assert from 'node:assert/strict';
import { load } from '../../wasm/index.js';
import { leaningBlock } from './leaning_block.mjs';

const MB = 1 << 20;

test('memory grows for a large file, and arrays taken before stay what they were', async () => {
  const engine = await load({ threads: 1 });
  const slicer = engine.createSlicer();
  slicer.setModel(leaningBlock(), 'block.tet');
  await slicer.runTo('tetrahedralize');
  const before = slicer.tets();
  const copy = before.positions.slice();
  assert.equal(engine.memoryBytes, 64 * MB);
  const other = engine.createSlicer();
  other.setModel(new Uint8Array(100 * MB), 'zeros.stl');
  assert.ok(engine.memoryBytes > 160 * MB);
  assert.deepEqual(before.positions, copy);
  assert.deepEqual(slicer.tets(), before);
  await slicer.runTo('layers');
  assert.ok(slicer.layers().count > 5);
  engine.dispose();
});

test('fifty runs take no more memory than five', async () => {
  const engine = await load({ threads: 1 });
  const block = leaningBlock([2, 2, 3], [6, 4, 6]);
  const sizes = [];
  for (let run = 0; run < 50; ++run) {
    const slicer = engine.createSlicer();
    slicer.setModel(block, 'block.tet');
    // Tall beads: what is measured is memory, not toolpaths.
    slicer.setParams({ 'nozzle.diameter': 2, 'toolpath.spacing': 3 });
    await slicer.run();
    slicer.layers();
    slicer.waypoints();
    slicer.exportFile('program.gcode');
    slicer.dispose();
    sizes.push(engine.memoryUsed);
  }
  engine.dispose();
  assert.ok(Math.max(...sizes.slice(5)) <= sizes[4] + 4096, `bytes in use after each run: ${sizes}`);
});
