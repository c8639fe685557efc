// How the cost of a run grows with the number of tets: slices one model at several resolutions and fits the exponent
// of every stage's CPU seconds by least squares on logarithms. One JSON object a line.
//   ./dev bench scaling MODEL [TETS,TETS,…] [--any.param value …]
// Where S3_CALIBRATE names the calibration program it runs before and after, and the fit takes seconds divided by the
// mean of the two.
import { spawnSync } from 'node:child_process';
import { join, resolve } from 'node:path';

const bench = join(resolve(process.env.S3_BUILD ?? 'build/native'), 's3bench');
const [model, ...rest] = process.argv.slice(2);
if (!model) {
  console.error('usage: ./dev bench scaling MODEL [TETS,TETS,…] [--any.param value …]');
  process.exit(2);
}
const targets = rest[0] && !rest[0].startsWith('--') ? rest.shift().split(',').map(Number) : [25000, 50000, 100000, 200000, 400000];

function execute(program, args) {
  const run = spawnSync(program, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });
  if (run.status !== 0) process.exit(run.status ?? 1);
  return run.stdout;
}

const calibrate = () => (process.env.S3_CALIBRATE ? Number(execute(process.env.S3_CALIBRATE, []).split(' ')[1]) : null);

/** Slope of the line through the points (log x, log y) that leaves the least squares. */
function exponent(points) {
  const xs = points.map(([x]) => Math.log(x)), ys = points.map(([, y]) => Math.log(y));
  const mean = (v) => v.reduce((a, b) => a + b, 0) / v.length, x = mean(xs), y = mean(ys);
  return xs.reduce((s, v, i) => s + (v - x) * (ys[i] - y), 0) / xs.reduce((s, v) => s + (v - x) ** 2, 0);
}

const points = new Map();
let before = calibrate();
for (const target of targets) {
  const lines = execute(bench, [model, '--threads', '1', '--mesh.target_tets', String(target), ...rest]).trim().split('\n').map((l) => JSON.parse(l));
  const after = calibrate(), tets = lines.at(-1).tets, unit = before ? (before + after) / 2 : 1;
  for (const { stage, cpu_s: seconds, wall_s, ...line } of lines) {
    console.log(JSON.stringify({ ...line, tets, stage, cpu_s: seconds, wall_s, ...(before && { calibration_cpu_s: unit }) }));
    if (!points.has(stage)) points.set(stage, []);
    points.get(stage).push([tets, seconds / unit]);
  }
  before = after;
}
for (const [stage, list] of points)
  if (list.length > 1 && list.at(-1)[1] > 0.05) console.log(JSON.stringify({ stage, exponent: Number(exponent(list).toFixed(3)) }));
