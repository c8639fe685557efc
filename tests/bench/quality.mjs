// Slices the paper's models by both methods and prints the README's table of figures; CPU s is the deformation's.
//   node tests/bench/quality.mjs MODELS_FOLDER [NAME…]
// MODELS_FOLDER holds the paper's models (ring.tet, topopt.tet, …); NAME picks rows. The programs come from
// $S3_BUILD, or build/native. Every run stays in out/quality/ for a look.
import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { jobs, runFlags } from './paper_jobs.mjs';

const models = process.argv[2];
const build = resolve(process.env.S3_BUILD ?? 'build/native');
const number = (x, digits) => (x === null || x === undefined ? '–' : x.toFixed(digits));
const columns = [
  ['model, objectives', (r) => r.label],
  ['layers', (r) => r.method],
  ['SF %', (r) => number(r.m.support_free_area_percent, 2)],
  ['violation °', (r) => number(r.m.support_free_mean_violation_deg, 4)],
  ['SQ %', (r) => number(r.m.surface_quality_area_percent, 1)],
  ['SR %', (r) => number(r.m.strength_critical_percent, 1)],
  ['Π rad', (r) => number(r.m.pi_rad, 4)],
  ['iterations', (r) => r.iterations ?? '–'],
  ['CPU s', (r) => number(r.seconds, 1)],
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
  const flags = [...runFlags(job, models), '--deform.method', method, '--threads', '1'];
  const run = spawnSync(join(build, 's3slice'), ['run', join(models, job.file), '-o', outdir, '--quiet', ...flags], { encoding: 'utf8' });
  if (run.status !== 0) {
    console.error(`${job.name} ${method}: exit ${run.status}\n${run.stderr}`);
    process.exitCode = 1;
    return [];
  }
  const report = JSON.parse(readFileSync(join(outdir, 'report.json'), 'utf8'));
  const rows = [{ label: job.label, method, m: report.curved, iterations: report.outer_iterations, seconds: report.cpu_s.outer_loop }];
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
