// The package against the native program, stage by stage, one JSON object a line:
//   node tests/bench/wasm.mjs MODEL [--tets N] [--until STAGE] [--threads N] [--cancels N] [--any.param value …]
// Both builds run the same job with one thread, then with N (default: all processors); seconds are wall.
// With threads each stage is then cancelled at N moments (default 8) spread over it: longest_wait_s is the longest time
// until a cancel was answered. With one thread a cancel waits for the end of the stage: longest_stage_s.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { availableParallelism, tmpdir } from 'node:os';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { load } from '../../wasm/index.js';
import { canceller } from '../wasm/canceller.mjs';

const root = join(dirname(fileURLToPath(import.meta.url)), '..', '..');
const [model, ...rest] = process.argv.slice(2);
if (!model) throw new Error('usage: node tests/bench/wasm.mjs MODEL [--tets N] [--until STAGE] [--threads N] [--cancels N] [--any.param value …]');
let [until, threads, cancels] = ['layers', availableParallelism(), 8];
const params = {};
for (let i = 0; i < rest.length; i += 2) {
  const [key, value] = [rest[i].replace(/^--/, ''), rest[i + 1]];
  if (key === 'until') until = value;
  else if (key === 'threads') threads = Number(value);
  else if (key === 'cancels') cancels = Number(value);
  else params[key === 'tets' ? 'mesh.target_tets' : key] = Number.isNaN(Number(value)) ? value : Number(value);
}

/** Seconds by stage of the native program. */
function native(count) {
  const folder = mkdtempSync(join(tmpdir(), 's3bench-'));
  try {
    const flags = Object.entries(params).flatMap(([key, value]) => [`--${key}`, String(value)]);
    execFileSync(join(root, 'build', 'native', 's3slice'), ['run', model, '-o', folder, '--quiet', '--until', until, '--threads', String(count), ...flags]);
    const { timings_s: t, peak_memory_mb, mesh } = JSON.parse(readFileSync(join(folder, 'report.json'), 'utf8'));
    const names = { mesh: 'repair', export: null };
    const seconds = (stage) => t[names[stage] === undefined ? stage : names[stage]];
    return { seconds, peak_memory_mb, tets: mesh.tets };
  } finally {
    rmSync(folder, { recursive: true });
  }
}

async function wasm(count) {
  const engine = await load({ threads: count });
  const slicer = engine.createSlicer();
  slicer.setModel(readFileSync(model), basename(model));
  slicer.setParams(params);
  await slicer.runTo(until);
  const stages = slicer.stages().filter(({ state }) => state === 'done');
  const { peak_memory_mb, mesh } = slicer.report();
  slicer.dispose();
  const waits = count > 1 && cancels > 0 ? await longestWaits(engine, stages) : {};
  engine.dispose();
  return { stages, peak_memory_mb, tets: mesh.tets, waits };
}

/** By stage: the longest seconds from a cancel, given by another thread while the stage runs, to its answer. */
async function longestWaits(engine, stages) {
  const slicer = engine.createSlicer();
  slicer.setModel(readFileSync(model), basename(model));
  slicer.setParams(params);
  const cancel = await canceller(slicer.cancelFlag);
  const waits = {};
  for (const { stage, seconds } of stages) {
    waits[stage] = 0;
    let done = false;
    for (let k = 0; k < cancels && !done; ++k) {
      cancel.in((1000 * seconds * (k + 0.5)) / cancels);
      try {
        slicer.advance();
        done = true;
      } catch (error) {
        if (error.kind !== 'cancelled') throw error;
        waits[stage] = Math.max(waits[stage], cancel.since() / 1000);
      }
    }
    while (done && cancel.since() === null) await new Promise((resolve) => setTimeout(resolve, 5)); // the last one came too late
    slicer.clearCancel();
    if (!done) slicer.advance();
  }
  await cancel.end();
  slicer.dispose();
  return waits;
}

for (const count of new Set([1, threads])) {
  const a = native(count);
  const b = await wasm(count);
  let [sumNative, sumWasm] = [0, 0];
  for (const { stage, seconds } of b.stages) {
    const before = a.seconds(stage);
    if (before === null || before === undefined) continue;
    sumNative += before;
    sumWasm += seconds;
    console.log(JSON.stringify({ threads: count, stage, native_s: before, wasm_s: seconds, ratio: seconds / before, longest_wait_s: b.waits[stage] }));
  }
  const longest = Math.max(...b.stages.map(({ seconds }) => seconds));
  console.log(JSON.stringify({ threads: count, stage: 'total', tets: b.tets, native_s: sumNative, wasm_s: sumWasm, ratio: sumWasm / sumNative, longest_stage_s: longest, longest_wait_s: b.waits.mesh === undefined ? undefined : Math.max(...Object.values(b.waits)), native_mb: a.peak_memory_mb, wasm_mb: b.peak_memory_mb }));
}
