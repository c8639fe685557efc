// The package as its users see it: from bytes to arrays, files and projects.
import test from 'node:test';
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { load, pathKinds, writeZip } from '../../wasm/index.js';
import { leaningBlock, root } from './leaning_block.mjs';

const engine = await load({ threads: 1 });
const s3slice = join(root, 'build', 'native', 's3slice');

function slicerWithBlock(params = {}) {
  const slicer = engine.createSlicer();
  slicer.setModel(leaningBlock(), 'block.tet');
  slicer.setParams(params);
  return slicer;
}

const states = (slicer) => Object.fromEntries(slicer.stages().map(({ stage, state }) => [stage, state]));

/** Every `width` numbers are a unit vector. */
function assertUnit(array, width, what) {
  for (let i = 0; i < array.length; i += width) {
    const length = Math.hypot(...array.subarray(i, i + width));
    assert.ok(Math.abs(length - 1) < 1e-5, `${what} ${i / width} has the length ${length}`);
  }
}

test('a run goes from bytes to arrays that fit together', async () => {
  const slicer = slicerWithBlock();
  assert.equal(slicer.layers(), null);
  assert.equal(slicer.metrics(), null);
  const done = [];
  const progress = [];
  await slicer.run({ onStage: (info) => done.push(info), onProgress: (p) => progress.push(p) });
  assert.deepEqual(done.map(({ stage }) => stage), slicer.stages().map(({ stage }) => stage));
  for (const info of slicer.stages()) {
    assert.equal(info.state, 'done');
    assert.ok(info.seconds >= 0 && info.cpuSeconds >= 0 && info.label.length > 2);
  }
  assert.ok(progress.every(({ fraction }) => fraction >= 0 && fraction <= 1));
  assert.deepEqual(slicer.advance(), { state: 'done', stage: null });

  const tets = slicer.tets();
  const [v, t, b] = [tets.positions.length / 3, tets.tets.length / 4, tets.boundaryTets.length];
  assert.equal(v, 5 * 4 * 6);
  assert.equal(t, 6 * 4 * 3 * 5);
  assert.ok(tets.tets.every((i) => i < v) && tets.boundaryFaces.every((i) => i < v) && tets.boundaryTets.every((i) => i < t));
  assert.equal(slicer.surface().indices.length, 3 * b);
  assert.equal(slicer.stress(), null);

  const faces = slicer.faces();
  assert.equal(faces.areas.length, b);
  assertUnit(faces.normals, 3, 'normal');
  const onPlate = faces.areas.filter((_, f) => faces.exempt[f]).reduce((a, c) => a + c, 0);
  assert.ok(Math.abs(onPlate - 8 * 6) < 1e-4);

  const { deformed, field, printDirections, rotations, residuals } = slicer.deformation({ precision: 64 });
  assert.ok(deformed instanceof Float64Array);
  assert.deepEqual([deformed.length, field.length, printDirections.length, rotations.length], [3 * v, v, 3 * t, 4 * t]);
  assertUnit(printDirections, 3, 'direction');
  assertUnit(rotations, 4, 'rotation');
  assert.ok(residuals.length > 0);

  const metrics = slicer.metrics();
  const share = (flags) => {
    let [flagged, total] = [0, 0];
    for (let f = 0; f < b; ++f) if (!faces.exempt[f]) (total += faces.areas[f]), flags[f] && (flagged += faces.areas[f]);
    return (100 * flagged) / total;
  };
  for (const which of ['curved', 'planar']) {
    const angles = slicer.faceAngles({ which });
    assert.ok(Math.abs(share(angles.overhang) - (100 - metrics[which].support_free_area_percent)) < 1e-3);
    assert.ok(Math.abs(share(angles.stairs) - (100 - metrics[which].surface_quality_area_percent)) < 1e-3);
  }
  assert.ok(metrics.curved.support_free_area_percent > metrics.planar.support_free_area_percent + 1);
  assert.equal(metrics.curved.strength_critical_percent, null);
  assert.equal(slicer.gouging().angles.length, metrics.curved.gouging_pairs);

  for (const which of ['curved', 'planar']) {
    const layers = slicer.layers({ which });
    assert.equal(layers.count, metrics[which].components);
    const vertices = layers.positions.length / 3;
    assert.deepEqual([layers.vertexOffsets[0], layers.vertexOffsets[layers.count]], [0, vertices]);
    assert.deepEqual([layers.indexOffsets[0], layers.indexOffsets[layers.count]], [0, layers.indices.length]);
    for (let c = 0; c < layers.count; ++c)
      for (let i = layers.indexOffsets[c]; i < layers.indexOffsets[c + 1]; ++i)
        assert.ok(layers.indices[i] >= layers.vertexOffsets[c] && layers.indices[i] < layers.vertexOffsets[c + 1]);
    assertUnit(layers.normals, 3, 'normal');
    assert.equal(layers.sourceTets.length * 3, layers.indices.length);
    assert.equal(layers.restsOnOffsets[layers.count], layers.restsOn.length);
    const { thickness } = slicer.histogramData({ which });
    assert.equal(thickness.values.length, vertices);

    const w = slicer.waypoints({ which });
    assert.ok(w.count > 100);
    assert.equal(w.positions.length, 3 * w.count);
    assertUnit(w.normals, 3, 'normal');
    assert.ok(w.components.every((c) => c < layers.count) && w.kinds.every((k) => k < pathKinds.length));
    for (let i = 0; i < w.count; ++i)
      assert.ok(Math.abs(w.tilts[i] - (Math.acos(Math.min(1, w.normals[3 * i + 2])) * 180) / Math.PI) < 0.1);
  }
  const motion = slicer.motion();
  assert.ok(motion.times.every((time, i) => i === 0 || time >= motion.times[i - 1]));
  const total = motion.durations.reduce((a, c) => a + c, 0);
  assert.ok(Math.abs(motion.times.at(-1) - total) < 1e-3 * total);
  slicer.dispose();
});

test('exports are the files of the command line', async () => {
  const slicer = slicerWithBlock();
  await slicer.run();
  const list = slicer.listExports();
  const names = list.map(({ name }) => name);
  for (const name of ['job.json', 'report.json', 'fields.vtu', 'layers/0000.ply', 'waypoints.csv', 'program.gcode', 'support_free.svg'])
    assert.ok(names.includes(name), name);
  for (const name of names) assert.ok(slicer.exportFile(name).length > 20, name);
  const text = (name) => new TextDecoder().decode(slicer.exportFile(name));
  assert.equal(text('waypoints.csv').trim().split('\n').filter((line) => !line.startsWith('#')).length - 1, slicer.waypoints().count);
  assert.equal(names.filter((name) => name.startsWith('layers/')).length, slicer.layers().count);
  assert.match(text('program.gcode'), /\nG1 /);
  const report = slicer.report();
  assert.deepEqual(report.curved, slicer.metrics().curved);
  assert.equal(report.input.file, 'block.tet');
  assert.deepEqual(slicer.plots().map(({ name }) => name), names.filter((name) => name.endsWith('.svg')));
  assert.throws(() => slicer.exportFile('nothing.txt'), { code: 'export.unknown_file' });
  slicer.dispose();
});

test('a changed parameter makes stale what depends on it, an equal one nothing', async () => {
  const slicer = slicerWithBlock();
  await slicer.runTo('waypoints');
  slicer.setParams(slicer.givenParams());
  slicer.setModel(leaningBlock(), 'block.tet');
  assert.equal(states(slicer).waypoints, 'done');
  slicer.setParams({ 'toolpath.spacing': 2 });
  assert.deepEqual([states(slicer).toolpaths, states(slicer).waypoints], ['done', 'stale']);
  slicer.setParams({ objectives: { alpha: 40 } });
  assert.deepEqual([states(slicer).tetrahedralize, states(slicer).objectives], ['done', 'stale']);
  assert.equal(slicer.layers(), null);
  slicer.setModel(leaningBlock([4, 3, 4]), 'block.tet');
  assert.equal(states(slicer).mesh, 'stale');
  slicer.dispose();
});

test('parameters nest at their dots; what is derived follows', () => {
  const slicer = slicerWithBlock({ 'nozzle.diameter': 0.8, layers: { max_thickness: 0.7 } });
  assert.equal(slicer.givenParams().nozzle.diameter, 0.8);
  assert.equal(slicer.givenParams().layers.min_thickness, 0);
  assert.ok(Math.abs(slicer.params().layers.min_thickness - 0.32) < 1e-12);
  slicer.setParams({ 'nozzle.diameter': 0.4, 'layers.max_thickness': 0 });
  assert.ok(Math.abs(slicer.params().layers.max_thickness - 0.4) < 1e-12);
  slicer.resetParams({ 'objectives.surface_quality': 0.5 });
  assert.equal(slicer.givenParams().nozzle.diameter, slicer.schema().properties.nozzle.properties.diameter.default);
  assert.equal(slicer.params().objectives.surface_quality, 0.5);
  assert.equal(slicer.params().model, 'block.tet');
  slicer.dispose();
});

test('the schema and the report on a model are those of the command line', () => {
  assert.deepEqual(engine.schema(), JSON.parse(execFileSync(s3slice, ['schema'], { encoding: 'utf8' })));
  const path = join(root, 'models', 'ring.stl');
  const native = JSON.parse(execFileSync(s3slice, ['inspect', path, '--json'], { encoding: 'utf8', maxBuffer: 1 << 26 }));
  const here = engine.inspect(readFileSync(path), path);
  assert.deepEqual(Object.keys(here), Object.keys(native));
  for (const key of ['triangles', 'closed', 'valid', 'open_edges', 'self_intersections', 'mesher', 'warnings', 'repairs'])
    assert.deepEqual(here[key], native[key], key);
});

test('the file can be looked at before anything is computed', () => {
  const slicer = engine.createSlicer();
  slicer.setModel(readFileSync(join(root, 'models', 'trio.stl')), 'trio.stl');
  const file = slicer.fileSurface();
  assert.equal(file.partOfTriangle.length * 3, file.indices.length);
  assert.ok(file.indices.every((i) => i < file.positions.length / 3));
  assert.ok(slicer.inspect().triangles === file.partOfTriangle.length);
  assert.equal(slicer.placement(), null);
  slicer.setParams({ 'input.scale': 2 });
  slicer.advance();
  const matrix = slicer.placement();
  assert.equal(matrix[0], 2);
  assert.equal(matrix[15], 1);
  slicer.dispose();
});

test('a load case gives stress, and strength can use it', async () => {
  const slicer = slicerWithBlock({ 'objectives.strength': 0.5 });
  const loads = {
    material: 'PLA',
    conditions: [
      { region: 'plate', fixed: true },
      { region: { half_space: { point: [0, 0, 9.9], normal: [0, 0, 1] } }, force: [0, 0, 40] },
    ],
  };
  slicer.setLoadCase(loads, 'pull.json');
  assert.equal(slicer.params().strength.load_case, 'pull.json');
  await slicer.runTo('fea');
  const stress = slicer.stress({ precision: 64 });
  const count = stress.sigmaMax.length;
  assertUnit(stress.tauMax, 3, 'direction');
  assert.equal(stress.tensors.length, 6 * count);
  const critical = stress.critical.reduce((a, c) => a + c, 0);
  assert.ok(critical > 0 && critical <= 0.3 * count);
  // Every critical tet is pulled at least as much as every other one.
  const least = Math.min(...stress.sigmaMax.filter((_, t) => stress.critical[t]));
  assert.ok(stress.sigmaMax.every((value, t) => stress.critical[t] || value <= least));
  assert.ok(slicer.listExports().some(({ name }) => name === 'stress.csv'));
  slicer.setLoadCase(null);
  assert.equal(slicer.params().strength.load_case, '');
  assert.throws(() => slicer.advance(), { code: 'fea.no_stress' });
  slicer.dispose();
});

test('SQ can be asked of a region, and tets can be made critical', async () => {
  const slicer = slicerWithBlock({ 'objectives.surface_quality': 0.5, 'objectives.strength': 0.5, 'strength.critical_ratio': 0 });
  slicer.setLoadCase({ conditions: [{ region: 'plate', fixed: true }, { region: { half_space: { point: [0, 0, 9.9], normal: [0, 0, 1] } }, force: [0, 0, 40] }] });
  const upper = { region: { half_space: { point: [0, 0, 6], normal: [0, 0, 1] } } };
  slicer.setSurfaceRegion(upper, 'upper.json');
  slicer.setCriticalRegion(JSON.stringify(upper));
  assert.deepEqual([slicer.params().objectives.surface_region, slicer.params().strength.critical_region], ['upper.json', 'critical.json']);
  await slicer.run();
  const { positions, tets, boundaryFaces } = slicer.tets(), { wantsQuality } = slicer.faces(), { critical } = slicer.stress();
  const height = (vertices) => vertices.reduce((sum, v) => sum + positions[3 * v + 2], 0) / vertices.length;
  critical.forEach((flag, t) => assert.equal(flag === 1, height([...tets.subarray(4 * t, 4 * t + 4)]) > 6));
  wantsQuality.forEach((flag, f) => assert.equal(flag === 1, height([...boundaryFaces.subarray(3 * f, 3 * f + 3)]) > 6));
  assert.ok(critical.includes(1) && critical.includes(0) && wantsQuality.includes(1) && wantsQuality.includes(0));
  const { curved } = slicer.metrics();
  assert.ok(curved.surface_quality_region_percent >= 0 && curved.surface_quality_region_percent !== curved.surface_quality_area_percent);
  assert.throws(() => slicer.setSurfaceRegion({ regoin: 1 }), { code: 'objectives.bad_region', stage: 'objectives' });

  const other = engine.createSlicer();
  other.openProject(slicer.saveProject());
  assert.deepEqual(other.inputFiles(), slicer.inputFiles());
  assert.deepEqual(other.params(), slicer.params());
  slicer.setSurfaceRegion(null);
  await slicer.runTo('objectives');
  assert.ok(slicer.faces().wantsQuality.every((flag, f) => flag === 1 - slicer.faces().exempt[f]));
  slicer.dispose();
  other.dispose();
});

test('machine profiles can be read, changed and given back', async () => {
  const profile = engine.machineProfile('head-ab');
  assert.equal(profile.kinematics, 'head_ab');
  const slicer = slicerWithBlock();
  slicer.setMachineProfile('mine', { ...profile, max_tilt_deg: 33, print_speed: 7 });
  slicer.setParams({ machine: 'mine' });
  assert.ok(Math.abs(slicer.params().deform.max_tilt - 33) < 1e-9);
  await slicer.runTo('waypoints');
  assert.ok(slicer.waypoints().speeds.some((speed) => Math.abs(speed - 7) < 1e-5));
  slicer.dispose();
});

test('a project reopens exactly, and runs natively when unpacked', async () => {
  const slicer = slicerWithBlock({ 'nozzle.diameter': 0.9, machine: 'head-ab', 'toolpath.spacing': 1.5 });
  slicer.setMachineProfile('shop/my machine', { inherits: 'head-ab', print_speed: 11 });
  slicer.setParams({ machine: 'shop/my machine' });
  slicer.setLoadCase('{"conditions": [{"region": "plate", "fixed": true}, {"gravity": [0, 0, 9.81]}]}', 'loads.json');
  await slicer.runTo('layers');
  const extra = { camera: [1, 2, 3], name: 'übung' };
  const project = slicer.saveProject(extra);

  const other = engine.createSlicer();
  assert.deepEqual(other.openProject(project), extra);
  assert.deepEqual(other.givenParams(), slicer.givenParams());
  assert.deepEqual(other.params(), slicer.params());
  assert.deepEqual(other.inputFiles(), slicer.inputFiles());
  assert.deepEqual(other.saveProject(extra), project);
  await other.runTo('layers');
  assert.deepEqual(other.layers({ precision: 64 }), slicer.layers({ precision: 64 }));

  const folder = mkdtempSync(join(tmpdir(), 's3project-'));
  try {
    writeFileSync(join(folder, 'project.zip'), project);
    execFileSync('python3', ['-m', 'zipfile', '-e', 'project.zip', '.'], { cwd: folder });
    execFileSync(s3slice, ['run', '--config', 'job.json', '-o', 'out', '--until', 'layers', '--quiet'], { cwd: folder });
    const job = JSON.parse(readFileSync(join(folder, 'out', 'job.json'), 'utf8'));
    assert.equal(job.deform.max_tilt, slicer.params().deform.max_tilt);
    assert.equal(job.nozzle.diameter, 0.9);
  } finally {
    rmSync(folder, { recursive: true });
  }
  slicer.dispose();
  other.dispose();
});

test('files become an archive that other programs read', () => {
  const archive = writeZip([{ name: 'a/ä.txt', bytes: new TextEncoder().encode('one') }, { name: 'b', bytes: new Uint8Array(3) }]);
  const folder = mkdtempSync(join(tmpdir(), 's3zip-'));
  try {
    writeFileSync(join(folder, 't.zip'), archive);
    const script = "import zipfile; z = zipfile.ZipFile('t.zip'); print(z.testzip(), z.namelist(), z.read(z.namelist()[0]))";
    const listed = execFileSync('python3', ['-c', script], { cwd: folder, encoding: 'utf8' });
    assert.equal(listed.trim(), "None ['a/ä.txt', 'b'] b'one'");
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('a damaged project is refused', () => {
  const slicer = slicerWithBlock();
  const project = slicer.saveProject();
  const cut = project.slice(0, project.length - 30);
  const changed = project.slice();
  changed[changed.indexOf(0x34, 2000)] ^= 1;  // a digit of the model
  for (const bytes of [new Uint8Array(0), new TextEncoder().encode('no archive'), cut, changed])
    assert.throws(() => slicer.openProject(bytes), { code: 'project.bad_file', kind: 'input' });
  slicer.dispose();
});

test('the version is that of the project', () => {
  const text = readFileSync(join(root, 'CMakeLists.txt'), 'utf8');
  const version = /project\(s3slicer VERSION ([\d.]+)/.exec(text)[1];
  assert.equal(engine.version, version);
  assert.equal(JSON.parse(readFileSync(join(root, 'wasm', 'package.json'), 'utf8')).version, version);
});
