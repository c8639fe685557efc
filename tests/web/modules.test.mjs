// Parts of the browser app that need no browser.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { test } from 'node:test';
import { load } from './typescript.mjs';

const near = (a, b, tolerance = 1e-9) => assert.ok(Math.abs(a - b) <= tolerance, `${a} is not ${b}`);

// --- settings

const schema = {
  type: 'object',
  properties: {
    model: { key: 'model', title: 'Model', type: 'string', default: '', stage: 'mesh' },
    mesh: { type: 'object', properties: { target_tets: { key: 'mesh.target_tets', title: 'Tets', type: 'integer', unit: '', description: 'Wanted number of tets.', default: 100000, minimum: 0, maximum: 5000000, stage: 'tetrahedralize' } } },
    deform: {
      type: 'object',
      properties: {
        method: { key: 'deform.method', title: 'Method', type: 'string', description: 'How.', default: 'refined', enum: ['refined', 'paper'], stage: 'outer_loop' },
        max_tilt: { key: 'deform.max_tilt', title: 'Largest tilt', type: 'number', unit: 'deg', description: 'Angle from z.', default: 0, minimum: 0, maximum: 90, stage: 'outer_loop', 'x-advanced': true },
      },
    },
  },
};

test('the form shows every leaf of the schema but those that name files', async () => {
  const { schemaFields, defaultsOf, groupFields } = await load('settings.ts');
  const fields = schemaFields(schema);
  assert.deepEqual(fields.map((field) => field.key), ['mesh.target_tets', 'deform.method', 'deform.max_tilt']);
  assert.deepEqual(defaultsOf(fields), { 'mesh.target_tets': 100000, 'deform.method': 'refined', 'deform.max_tilt': 0 });
  assert.equal(fields[2].advanced, true);
  assert.deepEqual(groupFields(fields).map((group) => group.fields.length), [1, 2]);
});

test('text becomes a value only where type, range and choice allow it', async () => {
  const { schemaFields, parseValue } = await load('settings.ts');
  const [tets, method, tilt] = schemaFields(schema);
  assert.deepEqual(parseValue(tets, ' 5000 '), { value: 5000 });
  assert.match(parseValue(tets, '50.5').problem, /whole number/);
  assert.match(parseValue(tets, '-1').problem, /from 0 to 5,000,000/);
  assert.deepEqual(parseValue(tilt, '12,5'), { value: 12.5 });
  assert.match(parseValue(tilt, '90.001').problem, /from 0 to 90 °/);
  assert.match(parseValue(tilt, '').problem, /A number/);
  assert.match(parseValue(tilt, 'NaN').problem, /A number/);
  assert.deepEqual(parseValue(method, 'paper'), { value: 'paper' });
  assert.match(parseValue(method, 'other').problem, /refined, paper/);
});

test('nested parameters become dotted keys without the names of files', async () => {
  const { flattenParams } = await load('settings.ts');
  assert.deepEqual(flattenParams({ model: 'a.stl', mesh: { target_tets: 5 }, strength: { load_case: 'x', critical_ratio: 0.3 } }), { 'mesh.target_tets': 5, 'strength.critical_ratio': 0.3 });
});

test('search finds all words in label, key or help', async () => {
  const { schemaFields, matches } = await load('settings.ts');
  const fields = schemaFields(schema);
  assert.deepEqual(fields.filter((field) => matches(field, 'TILT angle')).map((field) => field.key), ['deform.max_tilt']);
  assert.equal(fields.filter((field) => matches(field, '')).length, 3);
  assert.equal(fields.filter((field) => matches(field, 'tilt tets')).length, 0);
});

test('presets say only what they change, and are recognised by it', async () => {
  const { GOAL_PRESETS, matchesPreset } = await load('settings.ts');
  const values = { other: 1, ...GOAL_PRESETS[1].values };
  assert.deepEqual(GOAL_PRESETS.map((preset) => matchesPreset(preset, values)), [false, true, false]);
});

// --- history

test('undo and redo go through the steps; a drag is one step', async () => {
  const { History } = await load('history.ts');
  const history = new History(0);
  history.push(1);
  history.push(2, 'drag');
  history.push(3, 'drag');
  history.seal();
  history.push(4, 'drag');
  assert.deepEqual([history.undo(), history.undo(), history.undo(), history.undo()], [3, 1, 0, 0]);
  assert.deepEqual([history.redo(), history.redo()], [1, 3]);
  history.push(9);
  assert.equal(history.canRedo, false);
  assert.equal(history.undo(), 3);
});

// --- objectives

test('a corner of the triangle stands for one objective, the middle for all', async () => {
  const { CORNERS, weightsAt, pointOf } = await load('objectives.ts');
  assert.deepEqual(weightsAt(CORNERS[0]), [1, 0, 0]);
  assert.deepEqual(weightsAt(CORNERS[1]), [0, 1, 0]);
  assert.deepEqual(weightsAt(CORNERS[2]), [0, 0, 1]);
  assert.deepEqual(weightsAt({ x: 0.5, y: -3 }), [1, 0, 0]);
  near(pointOf([0, 0, 0]).x, 0.5);
  for (const weights of [[0.7, 0.3, 0], [0.5, 0, 0.5], [0.3, 0.35, 0.35]]) assert.deepEqual(weightsAt(pointOf(weights)), weights);
  const sum = weightsAt({ x: 0.43, y: 0.51 }).reduce((a, b) => a + b);
  near(sum, 1, 1e-12);
});

// --- rotation

test('angles and matrices are inverses, also where the middle axis stands upright', async () => {
  const { matrixOf, anglesOf } = await load('rotation.ts');
  for (const angles of [[10, 20, 30], [-170, 45, 90], [30, 90, 0], [12, -90, 77], [0, 0, 180]]) {
    const matrix = matrixOf(angles), again = matrixOf(anglesOf(matrix));
    matrix.forEach((value, i) => near(value, again[i], 1e-9));
  }
});

test('a face that is laid on the plate looks down, whatever the part was turned by', async () => {
  const { layOnPlate, matrixOf, unit } = await load('rotation.ts');
  const apply = (m, v) => [0, 3, 6].map((row) => m[row] * v[0] + m[row + 1] * v[1] + m[row + 2] * v[2]);
  for (const rotation of [[0, 0, 0], [33, -12, 140]]) {
    for (const own of [[1, 2, 3], [0, 0, 1], [0, 0, -1], [-1, 0, 0]]) {
      const normal = unit(own), seen = apply(matrixOf(rotation), normal);
      const down = apply(matrixOf(layOnPlate(rotation, seen)), normal);
      near(down[2], -1, 1e-7);
    }
  }
});

test('the preview stands on the plate: up axis, scale, rotation, lowest point at 0', async () => {
  const { previewPlacement, transformPoint, untransformPoint } = await load('rotation.ts');
  const points = [0, 1, 0, 0, 3, 0, 5, 2, 1];
  const m = previewPlacement(points, 'y', 10, [0, 0, 90]);
  assert.deepEqual(transformPoint(m, [0, 1, 0]).map((x) => Math.round(x * 1e6) / 1e6 + 0), [0, 0, 0]);
  near(transformPoint(m, [0, 3, 0])[2], 20, 1e-9);
  const back = untransformPoint(m, transformPoint(m, [5, 2, 1]));
  [5, 2, 1].forEach((x, i) => near(back[i], x, 1e-9));
});

test('the angles of a placement are those that it was made with', async () => {
  const { previewPlacement, placementAngles } = await load('rotation.ts');
  for (const up of ['z', 'y']) {
    placementAngles(previewPlacement([1, 2, 3], up, 25.4, [20, -30, 110]), up).forEach((angle, i) => near(angle, [20, -30, 110][i], 1e-9));
  }
});

test('rotations read and write as the parameter has them', async () => {
  const { parseRotation, formatRotation } = await load('rotation.ts');
  assert.deepEqual(parseRotation('90, 0,45'), [90, 0, 45]);
  assert.equal(parseRotation('auto'), null);
  assert.equal(parseRotation('1,2'), null);
  assert.equal(formatRotation([-1e-9, 270, 359.99999]), '0,-90,0');
});

// --- loads

// Two triangles of a square in z = 0 and one that stands on its edge 12.
const square = { positions: [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0.5, 1], indices: new Uint32Array([0, 1, 2, 0, 2, 3, 2, 1, 4]) };

test('a picked face spreads over what continues it and stops at the edge', async () => {
  const { floodFaces, triangleNeighbors, facesOf } = await load('load_case.ts');
  const neighbors = triangleNeighbors(square.indices, 5);
  assert.deepEqual([...neighbors], [-1, 2, 1, 0, -1, -1, 0, -1, -1]);
  const shape = { ...square, neighbors };
  assert.deepEqual(floodFaces(shape, 0, 25).sort(), [0, 1]);
  assert.deepEqual(floodFaces(shape, 0, 95).sort(), [0, 1, 2]);
  assert.deepEqual(facesOf(shape, { kind: 'faces', point: [1.1, 0.5, 0.8], angle: 1 }), [2]);
  assert.deepEqual(facesOf(shape, { kind: 'sphere', center: [0.3, 0.7, 0], radius: 0.1 }), [1]);
});

test('loads become the core\'s load case, in the frame where the part stands', async () => {
  const { loadCaseJson, loadProblems, loadsFrom } = await load('load_case.ts');
  const region = { plate: false, patches: [], force: [0, 0, 0], axes: 'xyz', loadCase: 0 };
  const loads = {
    material: 'PETG',
    regions: [
      { ...region, id: 1, name: 'foot', kind: 'fixed', plate: true, axes: 'yz' },
      { ...region, id: 2, name: 'top', kind: 'force', force: [0, 0, -50], patches: [{ kind: 'faces', point: [1, 2, 3], angle: 20 }, { kind: 'sphere', center: [0, 0, 0], radius: 2 }] },
    ],
  };
  // Twice as large, 5 mm up.
  const placement = [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 5, 1];
  assert.deepEqual(JSON.parse(loadCaseJson(loads, placement)), {
    material: 'PETG',
    regions: { '1 foot': ['plate'], '2 top': [{ faces: { points: [[2, 4, 11]], angle: 20 } }, { sphere: { center: [0, 0, 5], radius: 4 } }] },
    conditions: [{ region: '1 foot', fixed: 'yz' }, { region: '2 top', force: [0, 0, -50] }],
  });
  assert.deepEqual(loadProblems(loads), []);
  assert.match(loadProblems({ ...loads, regions: loads.regions.slice(1) })[0], /Nothing holds/);
  assert.match(loadProblems({ ...loads, regions: [{ ...loads.regions[1], patches: [] }] })[0], /no faces/);
  assert.deepEqual(loadsFrom(JSON.parse(JSON.stringify(loads))), loads);
  assert.equal(loadsFrom({ material: 'PLA' }), null);
  const { loadCase, ...before } = loads.regions[0];  // as a project had it when there was one case
  assert.deepEqual(loadsFrom({ ...loads, regions: [before] }).regions, [loads.regions[0]]);
});

test('several load cases share what acts in every case, and each must be held and loaded', async () => {
  const { loadCaseJson, loadProblems } = await load('load_case.ts');
  const region = { plate: true, patches: [], force: [0, 0, 0], axes: 'xyz', loadCase: 0 };
  const loads = {
    material: 'PLA',
    regions: [
      { ...region, id: 1, name: 'foot', kind: 'fixed' },
      { ...region, id: 2, name: 'push', kind: 'force', force: [5, 0, 0], loadCase: 1 },
      { ...region, id: 3, name: 'pull', kind: 'force', force: [-5, 0, 0], loadCase: 3 },
      { ...region, id: 4, name: 'face', kind: 'surface' },
    ],
  };
  const placement = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  assert.deepEqual(loadProblems(loads), []);
  const file = JSON.parse(loadCaseJson(loads, placement));
  assert.deepEqual(Object.keys(file.regions), ['1 foot', '2 push', '3 pull']);
  assert.deepEqual(file.conditions, [{ region: '1 foot', fixed: true }]);
  assert.deepEqual(file.cases, [
    { name: 'Case 1', conditions: [{ region: '2 push', force: [5, 0, 0] }] },
    { name: 'Case 3', conditions: [{ region: '3 pull', force: [-5, 0, 0] }] },
  ]);
  const split = { ...loads, regions: loads.regions.map((one) => (one.id === 1 ? { ...one, loadCase: 1 } : one)) };
  assert.match(loadProblems(split).join(), /^Nothing holds the part in case 3/);
  assert.equal('conditions' in JSON.parse(loadCaseJson(split, placement)), false);
});

test('what is painted for one purpose becomes one region file; what is not painted gives none', async () => {
  const { regionJson, paintProblems, hasLoads } = await load('load_case.ts');
  const region = { plate: false, force: [0, 0, 0], axes: 'xyz', loadCase: 0 };
  const dab = (x) => ({ kind: 'sphere', center: [x, 0, 0], radius: 1 });
  const loads = {
    material: 'PLA',
    regions: [
      { ...region, id: 1, name: 'back', kind: 'surface', patches: [{ kind: 'faces', point: [1, 2, 3], angle: 20 }] },
      { ...region, id: 2, name: 'head', kind: 'surface', patches: [dab(1)] },
      { ...region, id: 3, name: 'core', kind: 'critical', patches: [] },
    ],
  };
  const placement = [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 5, 1];
  assert.deepEqual(JSON.parse(regionJson(loads, 'surface', placement)), {
    region: [{ faces: { points: [[2, 4, 11]], angle: 20 } }, { sphere: { center: [2, 0, 5], radius: 2 } }],
  });
  assert.equal(regionJson(loads, 'critical', placement), '');
  assert.equal(hasLoads(loads), false);
  assert.deepEqual(paintProblems(loads, 'surface'), []);
  assert.match(paintProblems(loads, 'critical')[0], /core.*no faces/);
  const many = { ...loads, regions: [{ ...loads.regions[1], patches: Array.from({ length: 1500 }, (_, i) => dab(i)) }] };
  assert.match(paintProblems(many, 'surface')[0], /too many dabs/);
  assert.equal(regionJson(many, 'surface', placement), '');
});

// --- tets

test('tets that share a face know each other, and a cut shows what lies behind', async () => {
  const { tetNeighbors, visibleFaces, tetCentroids } = await load('tet_topology.ts');
  // Two tets over the triangle 0 1 2: one above with 3, one below with 4.
  const tets = new Uint32Array([0, 1, 2, 3, 0, 2, 1, 4]);
  const neighbors = tetNeighbors(tets, 5);
  assert.deepEqual([...neighbors], [-1, -1, -1, 1, -1, -1, -1, 0]);
  const all = visibleFaces({ tets }, neighbors, () => true);
  assert.deepEqual([all.tets.length, all.firstInner], [6, 6]);
  const cut = visibleFaces({ tets }, neighbors, (tet) => tet === 0);
  assert.deepEqual([cut.tets.length, cut.firstInner], [4, 3]);
  assert.deepEqual([...cut.vertices.slice(9)].sort(), [0, 1, 2]);
  const positions = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1];
  assert.deepEqual([...tetCentroids({ tets, positions }, 2)], [0.25, -0.25]);
  // Faces look away from the fourth corner.
  for (let face = 0; face < 4; ++face) {
    const [a, b, c] = [0, 1, 2].map((k) => positions.slice(3 * cut.vertices[3 * face + k], 3 * cut.vertices[3 * face + k] + 3));
    const u = b.map((x, k) => x - a[k]), v = c.map((x, k) => x - a[k]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const out = a.map((x, k) => x - [0.25, 0.25, 0.25][k]);
    assert.ok(n[0] * out[0] + n[1] * out[1] + n[2] * out[2] > 0, `face ${face}`);
  }
});

// --- colours, figures, time

test('colours run from the first stop to the last and stay in range', async () => {
  const { colorize, table, extent, robustExtent } = await load('color_maps.ts');
  const map = table('viridis');
  const rgb = colorize([-5, 0, 10, 99, NaN], 'viridis', 0, 10);
  assert.deepEqual([...rgb.slice(0, 6)], [...map.slice(0, 3), ...map.slice(0, 3)]);
  assert.deepEqual([...rgb.slice(6, 12)], [...map.slice(-3), ...map.slice(-3)]);
  assert.deepEqual([...rgb.slice(12)], [150, 150, 150]);
  assert.deepEqual([...colorize([3], 'warm', 3, 3)], [...table('warm').slice(0, 3)]);
  assert.deepEqual(extent([3, -1, 2]), [-1, 3]);
  const outlier = Array.from({ length: 1000 }, (_, i) => i / 1000).concat(1e6);
  assert.ok(robustExtent(outlier)[1] < 1);
});

test('a histogram holds the whole weight', async () => {
  const { histogram, niceStep, metricRows } = await load('analysis.ts');
  const shares = histogram({ values: [0, 44.9, 45, 90], weights: [1, 1, 1, 1] }, 0, 90, 2);
  assert.deepEqual(shares, [50, 50]);
  assert.deepEqual([niceStep(0.3), niceStep(2), niceStep(70)], [0.5, 2, 100]);
  const rows = metricRows({ support_free_area_percent: 99, layers: 50, support_volume_mm3: null }, { support_free_area_percent: 90, layers: 40, support_volume_mm3: 5 });
  assert.deepEqual(rows.map((row) => [row.label, row.curved, row.planar, row.better]), [
    ['Support free', '99', '90', 'curved'], ['Support material', '–', '5', null], ['Layers', '50', '40', null],
  ]);
});

test('the plot of iterations has a dot for each, the largest on top', async () => {
  const { iterationSvg } = await load('analysis.ts');
  const svg = iterationSvg({ title: 'Π', axis: 'iteration', values: [4, 1, 0] });
  const dots = [...svg.matchAll(/cx="([\d.]+)" cy="([\d.]+)"/g)].map((match) => match.slice(1).map(Number));
  assert.equal(dots.length, 3);
  assert.ok(dots[0][0] < dots[1][0] && dots[1][0] < dots[2][0]);
  // Heights in proportion: 4 to 1 above the 0 of the last.
  near((dots[2][1] - dots[0][1]) / (dots[2][1] - dots[1][1]), 4, 0.05);
  assert.doesNotMatch(iterationSvg({ title: 'Π', axis: '', values: [0.5] }), /NaN|Infinity/);
});

test('the playhead finds its waypoint, and times follow from distances and speeds', async () => {
  const { firstAfter, estimate } = await load('timeline.ts');
  assert.deepEqual([0, 1, 1.5, 9].map((clock) => firstAfter([0, 1, 2, 3], clock, 0, 3)), [0, 1, 2, 3]);
  assert.deepEqual([...estimate([0, 0, 0, 3, 4, 0, 3, 4, 10], [0, 5, 2])], [0, 1, 6]);
});

// --- the worker's client

/** A worker of the test's own: `answer(call)` gives the messages that come back. */
function fakeWorker(answer) {
  const worker = {
    onmessage: null, onerror: null, terminated: false, heard: [],
    postMessage(message) {
      worker.heard.push(message);
      for (const reply of answer(message) ?? []) queueMicrotask(() => worker.onmessage?.({ data: reply }));
    },
    terminate() { worker.terminated = true; },
  };
  return worker;
}
const quiet = { onProgress() {}, onStages() {}, onCrash() {} };
const started = (message) => (message.name === 'start' ? [{ type: 'answer', id: message.id, value: { cancelFlag: null } }] : null);

test('answers find their calls, errors arrive with code and hint', async () => {
  const { SlicerClient } = await load('slicer_client.ts');
  const error = { kind: 'input', code: 'mesh.empty', stage: 'mesh', message: 'Nothing in it', hint: 'Take another', places: [] };
  const client = new SlicerClient(() => fakeWorker((message) => started(message)
    ?? (message.name === 'report' ? [{ type: 'answer', id: message.id, value: { layers: 3 } }] : [{ type: 'failure', id: message.id, error }])), quiet);
  await client.start({ engineUrl: '' });
  const [report, failure] = await Promise.allSettled([client.call('report'), client.call('inspect')]);
  assert.deepEqual(report.value, { layers: 3 });
  assert.deepEqual([failure.reason.code, failure.reason.hint, failure.reason.message], ['mesh.empty', 'Take another', 'Nothing in it']);
});

test('a worker that dies rejects what it owed, once, and names the stage; the next one works', async () => {
  const { SlicerClient } = await load('slicer_client.ts');
  const workers = [], crashes = [];
  const client = new SlicerClient(() => {
    const worker = fakeWorker((message) => started(message) ?? [{ type: 'progress', progress: { stage: 'layers', fraction: 0.5 }, memoryBytes: 1 }]);
    workers.push(worker);
    return worker;
  }, { ...quiet, onCrash: (error) => crashes.push(error) });
  await client.start({ engineUrl: '' });
  const run = client.call('run', { until: 'metrics' });
  await new Promise((resolve) => setTimeout(resolve, 5));
  workers[0].onerror({ message: 'out of memory' });
  workers[0].onerror({ message: 'again' });
  await assert.rejects(run, (error) => error.code === 'engine.crashed' && error.stage === 'layers' && /out of memory/.test(error.message));
  assert.equal(crashes.length, 1);
  assert.ok(workers[0].terminated);
  await assert.rejects(client.call('report'), { code: 'engine.crashed' });
  await client.start({ engineUrl: '' });
  assert.equal(workers.length, 2);
});

test('cancel sets the shared flag and tells the worker; stop ends its calls as cancelled', async () => {
  const { SlicerClient } = await load('slicer_client.ts');
  const flag = new Uint8Array(new SharedArrayBuffer(1));
  let worker;
  const client = new SlicerClient(() => (worker = fakeWorker((message) => (message.name === 'start' ? [{ type: 'answer', id: message.id, value: { cancelFlag: flag } }] : null))), quiet);
  await client.start({ engineUrl: '' });
  const run = client.call('run', { until: 'metrics' });
  client.cancel();
  assert.equal(flag[0], 1);
  assert.equal(worker.heard.at(-1).type, 'cancel');
  client.stop();
  await assert.rejects(run, { code: 'cancelled' });
  assert.ok(worker.terminated);
});

test('buffers are handed over once, and those shared between threads are not', async () => {
  const { transferables } = await load('protocol.ts');
  const buffer = new ArrayBuffer(8);
  const value = { a: new Float32Array(buffer), b: { c: new Uint8Array(buffer), d: new Uint8Array(new SharedArrayBuffer(4)) }, e: null, f: [1, 2] };
  assert.deepEqual(transferables(value), [buffer]);
});

// --- the whole

test('only main and view know three.js', () => {
  const source = new URL('../../web/src/', import.meta.url);
  for (const name of readdirSync(source, { recursive: true })) {
    if (!String(name).endsWith('.ts') || name === 'main.ts' || String(name).startsWith('view')) continue;
    const text = readFileSync(new URL(String(name), source), 'utf8');
    assert.doesNotMatch(text, /from 'three|from '\.{1,2}\/(\.\.\/)?view\//, String(name));
  }
});

test('the lock file names no registry', () => {
  const text = readFileSync(new URL('../../web/package-lock.json', import.meta.url), 'utf8');
  assert.doesNotMatch(text, /"resolved"/);
});
