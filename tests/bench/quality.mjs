// Slices the paper's models by both methods and prints the README's table of figures.
//   node tests/bench/quality.mjs MODELS_FOLDER [NAME…]
// MODELS_FOLDER holds the paper's models (ring.tet, topopt.tet, …); NAME picks rows. The programs come from
// $S3_BUILD, or build/native. Every run stays in out/quality/ for a look.
import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';

const models = process.argv[2];
const build = resolve(process.env.S3_BUILD ?? 'build/native');
const volume = ['--input.up', 'y'];
const quality = ['--objectives.support_free', '0.5', '--objectives.surface_quality', '0.5', '--objectives.gamma', '8'];

const jobs = [
  { name: 'ring', label: 'ring, SF', file: 'ring.tet', flags: [...volume] },
  { name: 'topopt', label: 'topopt, SF', file: 'topopt.tet', flags: [...volume] },
  { name: 'ankle', label: 'ankle, SF 0.5 SQ 0.5, γ 8°', file: 'ankle.tet', flags: [...volume, ...quality] },
  { name: 'bunny', label: 'bunny (197k tets asked), SF 0.5 SQ 0.5, γ 8°', file: 'bunny.off', flags: ['--mesh.target_tets', '197000', ...quality] },
  { name: 'topopt-sr', label: 'topopt, SF 0.7 SR 0.3', file: 'topopt.tet', stress: 'topopt_stress.csv', flags: [...volume, '--objectives.support_free', '0.7', '--objectives.strength', '0.3'] },
];

const number = (x, digits) => (x === null || x === undefined ? '–' : x.toFixed(digits));
const columns = [
  ['model, objectives', (r) => r.label],
  ['layers', (r) => r.method],
  ['SF %', (r) => number(r.m.support_free_area_percent, 2)],
  ['violation °', (r) => number(r.m.support_free_mean_violation_deg, 4)],
  ['SQ %', (r) => number(r.m.surface_quality_area_percent, 1)],
  ['SR %', (r) => number(r.m.strength_critical_percent, 1)],
  ['Π rad', (r) => number(r.m.pi_rad, 4)],
  ['foldovers', (r) => r.m.foldovers],
  ['gouging', (r) => r.m.gouging_pairs],
  ['concave', (r) => r.m.concave_pairs_over_20deg],
  ['islands', (r) => r.m.islands],
  ['isosurfaces', (r) => r.m.layers],
  ['outside thickness %', (r) => (r.method === 'planar' ? '–' : number(r.m.thickness_outside_area_percent, 4))],
  ['coverage %', (r) => number(r.m.coverage_percent, 1)],
  ['overlap %', (r) => number(r.m.overlap_percent, 1)],
];

function slice(job, method) {
  const outdir = join('out', 'quality', `${job.name}-${method}`);
  mkdirSync(outdir, { recursive: true });
  const flags = [...job.flags, '--deform.method', method, '--nozzle.diameter', '1'];
  if (job.stress) flags.push('--strength.stress_file', join(models, job.stress));
  const run = spawnSync(join(build, 's3slice'), ['run', join(models, job.file), '-o', outdir, '--quiet', ...flags], { encoding: 'utf8' });
  if (run.status !== 0) {
    console.error(`${job.name} ${method}: exit ${run.status}\n${run.stderr}`);
    process.exitCode = 1;
    return [];
  }
  const report = JSON.parse(readFileSync(join(outdir, 'report.json'), 'utf8'));
  const rows = [{ label: job.label, method, m: report.curved }];
  if (method === 'refined') rows.unshift({ label: job.label, method: 'planar', m: report.planar });
  return rows;
}

if (!models || !existsSync(join(models, 'ring.tet'))) {
  console.error('usage: node tests/bench/quality.mjs MODELS_FOLDER [NAME…]: the folder with ring.tet, topopt.tet, ankle.tet, bunny.off');
  process.exit(2);
}
const wanted = process.argv.slice(3);
console.log(`| ${columns.map((c) => c[0]).join(' | ')} |\n|${columns.map(() => '---|').join('')}`);
for (const job of jobs.filter((j) => wanted.length === 0 || wanted.includes(j.name)))
  for (const method of ['refined', 'paper'])
    for (const row of slice(job, method)) console.log(`| ${columns.map((c) => c[1](row)).join(' | ')} |`);
