// Everything that goes wrong is a SlicerError that says what, where and what to do.
import test from 'node:test';
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { fileURLToPath } from 'node:url';
import { load, SlicerError } from '../../wasm/index.js';
import { leaningBlock } from './leaning_block.mjs';

const engine = await load({ threads: 1 });
const encode = (text) => new TextEncoder().encode(text);

function slicerWithBlock(params = {}) {
  const slicer = engine.createSlicer();
  slicer.setModel(leaningBlock(), 'block.tet');
  slicer.setParams(params);
  return slicer;
}

/** @returns {SlicerError} */
function thrownBy(call) {
  try {
    call();
  } catch (error) {
    assert.ok(error instanceof SlicerError && error instanceof Error, String(error));
    assert.ok(error.message.length > 10);
    return error;
  }
  assert.fail('nothing was thrown');
}

test('a file that is no model names itself, and the stage has failed', () => {
  const slicer = engine.createSlicer();
  slicer.setModel(encode('this is not a mesh'), 'letter.stl');
  const error = thrownBy(() => slicer.advance());
  assert.deepEqual([error.kind, error.stage], ['input', 'mesh']);
  assert.match(error.code, /^mesh\./);
  assert.match(error.message, /letter\.stl/);
  assert.equal(slicer.stages()[0].state, 'failed');
  slicer.setModel(leaningBlock(), 'block.tet');
  assert.equal(slicer.advance().stage, 'mesh');
  slicer.dispose();
});

test('no model at all is an error, too', () => {
  const slicer = engine.createSlicer();
  assert.equal(thrownBy(() => slicer.advance()).code, 'mesh.empty_file');
  assert.equal(thrownBy(() => slicer.saveProject()).code, 'engine.usage');
  slicer.dispose();
});

test('a cut-off tet file is told by line', () => {
  const slicer = engine.createSlicer();
  slicer.setModel(leaningBlock().slice(0, 400), 'block.tet');
  assert.match(thrownBy(() => slicer.advance()).message, /block\.tet.*\d/);
  slicer.dispose();
});

test('a wrong parameter is told with key, value and range, and changes nothing', () => {
  const slicer = slicerWithBlock();
  const before = slicer.givenParams();
  const error = thrownBy(() => slicer.setParams({ 'objectives.alpha': 400, 'nozzle.diameter': 0.7 }));
  assert.equal(error.code, 'params.out_of_range');
  assert.match(error.message, /objectives\.alpha.*400/);
  assert.equal(thrownBy(() => slicer.setParams({ objectives: { alfa: 4 } })).code, 'params.unknown_key');
  assert.equal(thrownBy(() => slicer.setParams({ 'objectives.alpha': 'steep' })).code, 'params.wrong_type');
  assert.equal(thrownBy(() => slicer.setParams({ 'objectives.alpha': NaN })).code, 'params.wrong_type');
  assert.equal(thrownBy(() => slicer.setParams({ machine: 'anvil' })).code, 'machine.unknown');
  assert.equal(thrownBy(() => slicer.setParams({ __proto__: null, ['__proto__.x']: 1 })).code, 'params.unknown_key');
  assert.deepEqual(slicer.givenParams(), before);
  slicer.dispose();
});

test('a wrong load case and a wrong profile are refused when they are given', () => {
  const slicer = slicerWithBlock();
  const error = thrownBy(() => slicer.setLoadCase('{"conditions": [{"region": "nowhere", "fixed": true}]}', 'my loads.json'));
  assert.deepEqual([error.kind, error.code], ['input', 'fea.bad_load_case']);
  assert.match(error.message, /my loads\.json/);
  assert.equal(slicer.inputFiles().loadCase, null);
  assert.equal(thrownBy(() => slicer.setMachineProfile('mine', '{"inherits": "drill"}')).code, 'machine.unknown');
  assert.equal(thrownBy(() => slicer.setMachineProfile('mine', '{')).code, 'machine.bad_profile');
  slicer.dispose();
});

test('an error keeps its fields over postMessage', () => {
  const slicer = slicerWithBlock();
  const error = thrownBy(() => slicer.setParams({ machine: 'anvil' }));
  const back = SlicerError.from(structuredClone(error.toJSON()));
  assert.ok(back instanceof SlicerError);
  assert.deepEqual(back.toJSON(), error.toJSON());
  assert.equal(back.message, error.message);
  slicer.dispose();
});

test('wrong calls are usage errors and leave the engine alive', async () => {
  const slicer = slicerWithBlock();
  for (const call of [
    () => slicer.setModel('path.stl', 'path.stl'),
    () => slicer.setModel(leaningBlock(), 5),
    () => slicer.setParams(null),
    () => slicer.layers({ which: 'round' }),
    () => slicer.exportFile(undefined),
  ])
    assert.equal(thrownBy(call).code, 'engine.usage');
  await assert.rejects(slicer.runTo('mehs'), { code: 'engine.usage' });
  await assert.rejects(load({ threads: 0 }), { code: 'engine.usage' });
  assert.equal(engine.crashed, false);
  slicer.dispose();
  assert.equal(thrownBy(() => slicer.stages()).code, 'engine.usage');
  slicer.dispose();
});

test('what a callback throws arrives, and the stage can be done again', async () => {
  const slicer = slicerWithBlock();
  class Mine extends Error {}
  // The first report to come: which stage lasts long enough for one depends on the machine.
  await assert.rejects(
    slicer.run({
      onProgress: () => {
        throw new Mine('enough');
      },
    }),
    Mine,
  );
  const states = slicer.stages().map(({ state }) => state);
  assert.deepEqual(states, states.toSorted((a, b) => ['done', 'fresh'].indexOf(a) - ['done', 'fresh'].indexOf(b)));
  assert.notEqual(states.at(-1), 'done');
  await slicer.run();
  assert.equal(slicer.stages().at(-1).state, 'done');
  slicer.dispose();
});

test('artefacts that are not there are an error of loading', async () => {
  await assert.rejects(load({ threads: 1, baseUrl: 'file:///nowhere/' }), { name: 'SlicerError', code: 'engine.load' });
  await assert.rejects(load({ threads: 1, wasmBinary: new Uint8Array(20) }), { code: 'engine.load' });
});

test('a trap ends the engine, not the process; a new engine goes on', async () => {
  const memory = new WebAssembly.Memory({ initial: 1024, maximum: 65536 });
  const doomed = await load({ threads: 1, memory });
  const slicer = doomed.createSlicer();
  slicer.setModel(leaningBlock(), 'block.tet');
  slicer.advance();
  new Uint8Array(memory.buffer).fill(0xfe, 1024);  // as after a wild write
  const error = thrownBy(() => {
    while (slicer.advance().state === 'running');
  });
  assert.deepEqual([error.kind, error.code], ['engine', 'engine.crashed']);
  assert.ok(error.hint.length > 10);
  assert.equal(doomed.crashed, true);
  assert.equal(thrownBy(() => slicer.stages()).code, 'engine.crashed');
  assert.equal(thrownBy(() => doomed.createSlicer()).code, 'engine.crashed');
  slicer.dispose();
  doomed.dispose();
  const next = await load({ threads: 1 });
  assert.equal(next.createSlicer().stages()[0].state, 'fresh');
  next.dispose();
});

test('memory that runs out ends the engine with a sentence about memory', async () => {
  const small = await load({ threads: 1, memory: new WebAssembly.Memory({ initial: 1024, maximum: 1100 }) });
  const slicer = small.createSlicer();
  const error = thrownBy(() => slicer.setModel(new Uint8Array(80 << 20), 'zeros.stl'));
  assert.deepEqual([error.kind, error.code], ['engine', 'engine.crashed']);
  assert.match(error.message + error.hint, /memory/);
  assert.equal(small.crashed, true);
  small.dispose();
});

test('a trap in another thread than the calling one ends the engine, too', () => {
  const program = fileURLToPath(new URL('./trap_in_thread.mjs', import.meta.url));
  const said = execFileSync(process.execPath, [program], { encoding: 'utf8', timeout: 60000, stdio: ['ignore', 'pipe', 'ignore'] });
  const error = JSON.parse(said);
  assert.deepEqual([error.kind, error.code, error.crashed], ['engine', 'engine.crashed', true]);
});

test('memory that runs out in threads ends the engine with a sentence about memory', async () => {
  for (const maximum of [1100, 1800, 3000]) {
    const small = await load({ threads: 3, memory: new WebAssembly.Memory({ initial: 1024, maximum, shared: true }) });
    const slicer = small.createSlicer();
    slicer.setModel(leaningBlock([30, 30, 30], [30, 30, 30]), 'block.tet');
    const error = thrownBy(() => {
      while (slicer.advance().state === 'running');
    });
    assert.deepEqual([error.kind, error.code], ['engine', 'engine.crashed']);
    assert.match(error.message + error.hint, /memory/);
    small.dispose();
  }
});
