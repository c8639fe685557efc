// Runs s3slice and measures its files with a program that shares no code with it (evaluator.mjs): a bundled part
// always; the paper's models, against the figures that the project promises, where S3_SHARED names their folder.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, rmSync } from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { evaluate } from "./evaluator.mjs";
import { jobs, paperModels, runFlags } from "../bench/paper_jobs.mjs";
import { root, s3slice, testFolder } from "./program.mjs";

const folder = testFolder("evaluator");

function slice(name, model, ...flags) {
  const outdir = path.join(folder, name);
  const run = spawnSync(s3slice, ["run", model, "-o", outdir, "--quiet", ...flags], { encoding: "utf8" });
  assert.equal(run.status, 0, run.stderr);
  const result = evaluate(outdir);
  rmSync(outdir, { recursive: true });
  return result;
}

/** Fails with all that is wrong, not with the first of it. */
function check(name, bounds) {
  const wrong = bounds.filter(([, ok]) => !ok).map(([what, , value]) => `${what}: ${value}`);
  assert.deepEqual(wrong, [], name);
}

const near = (what, own, said, tolerance) => [
  `${what} is ${own} here and in the report`, own === said || Math.abs(own - said) <= tolerance, said,
];
const atMost = (what, value, bound) => [`${what} over ${bound}`, value <= bound, value];
const atLeast = (what, value, bound) => [`${what} under ${bound}`, value >= bound, value];

/** The report tells what the files hold. */
function agreement({ report: { curved }, field, thickness, coverage }) {
  return [
    near("SF area", field.support_free_area_percent, curved.support_free_area_percent, 1e-6),
    near("SF violation", field.support_free_mean_violation_deg, curved.support_free_mean_violation_deg, 1e-6),
    near("SQ area", field.surface_quality_area_percent, curved.surface_quality_area_percent, 1e-6),
    near("SR", field.strength_critical_percent, curved.strength_critical_percent, 1e-6),
    near("foldovers", field.foldovers, curved.foldovers, 0),
    near("gouging", field.gouging_pairs, curved.gouging_pairs, 0),
    near("concave pairs", field.concave_pairs_over_20deg, curved.concave_pairs_over_20deg, 0),
    // Measured at other points of the same triangles.
    near("median thickness", thickness.p50, curved.thickness_mm.p50, 0.005 * thickness.p50),
    near("thickness outside", thickness.outside_percent, curved.thickness_outside_area_percent, 0.01),
    // The report measures the paths before they become waypoints, whose chords stray by the tolerance of resampling.
    near("path length", coverage.path_length_mm, curved.path_length_mm, 0.005 * curved.path_length_mm),
    near("coverage", coverage.coverage_percent, curved.coverage_percent, 0.8),
    near("overlap", coverage.overlap_percent, curved.overlap_percent, 0.5),
  ];
}

/** What every print keeps. */
function soundness({ field, thickness, coverage }) {
  return [
    atMost("foldovers", field.foldovers, 0),
    atMost("gouging pairs", field.gouging_pairs, 0),
    // None at the samples that layers are trimmed by; these are others.
    atMost("thickness outside, %", thickness.outside_percent, 0.001),
    atLeast("coverage, %", coverage.coverage_percent, 97),
    atMost("overlap, %", coverage.overlap_percent, 5),
  ];
}

test("an independent program finds a bundled part as the report says", () => {
  // Thick beads and few tets: quick.
  const result = slice("ring", path.join(root, "models/ring.stl"), "--mesh.target_tets", "5000", "--nozzle.diameter", "2.5");
  check("ring", [
    ...agreement(result), ...soundness(result),
    atLeast("SF area, %", result.field.support_free_area_percent, 99.5),
    atMost("concave pairs", result.field.concave_pairs_over_20deg, 0),
  ]);
});

const promised = {
  ring: ({ field }) => [
    atLeast("SF area, %", field.support_free_area_percent, 99.9),
    atMost("SF violation, °", field.support_free_mean_violation_deg, 0.005),
    atMost("concave pairs", field.concave_pairs_over_20deg, 0),
  ],
  topopt: ({ field }) => [
    atLeast("SF area, %", field.support_free_area_percent, 99.3),
    atMost("concave pairs", field.concave_pairs_over_20deg, 20),
  ],
  ankle: ({ field }) => [
    atLeast("SF area, %", field.support_free_area_percent, 99.99),
    atLeast("SQ area, %", field.surface_quality_area_percent, 88),
    atMost("concave pairs", field.concave_pairs_over_20deg, 0),
  ],
  bunny: ({ field }) => [
    atLeast("SF area, %", field.support_free_area_percent, 99.9),
    atLeast("SQ area, %", field.surface_quality_area_percent, 75),
    atMost("concave pairs", field.concave_pairs_over_20deg, 40),
  ],
  "topopt-sr": ({ field, report }) => [
    atLeast("SF area, %", field.support_free_area_percent, 97),
    atLeast("SR of the critical tets, %", field.strength_critical_percent, 75),
    atMost("islands", report.curved.islands, 8),
  ],
};

const models = process.env.S3_SHARED && path.join(process.env.S3_SHARED, paperModels);
const skip = models && existsSync(path.join(models, "ring.tet")) ? false : `S3_SHARED names no folder with ${paperModels}`;
for (const job of jobs)
  test(`an independent program finds ${job.label} as promised`, { skip }, () => {
    const result = slice(job.name, path.join(models, job.file), ...runFlags(job, models));
    check(job.label, [...agreement(result), ...soundness(result), ...promised[job.name](result)]);
  });
