// Every kind of defect goes through to tets of the right volume, or ends in one sentence that names the file.
// Needs the native build: the folder of the programs in S3_BUILD, or build/native.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { describe, test } from "node:test";
import { defectiveFiles } from "./defects.mjs";
import { s3slice, testFolder } from "./program.mjs";

const folder = testFolder("defects");

/** @returns {Promise<{status: number|null, signal: string|null, stderr: string}>} */
function run(args) {
  return new Promise((resolve, reject) => {
    const child = spawn(s3slice, args, { cwd: folder, stdio: ["ignore", "ignore", "pipe"], timeout: 300000 });
    let stderr = "";
    child.stderr.on("data", (data) => (stderr += data));
    child.on("error", reject);
    child.on("close", (status, signal) => resolve({ status, signal, stderr }));
  });
}

async function check({ name, bytes, volume, refused, options = [] }) {
  writeFileSync(path.join(folder, name), bytes);
  const out = name.replace(".", "-");
  const { status, signal, stderr } = await run(["run", name, "-o", out, "--until", "tetrahedralize", "--mesh.target_tets", "6000", "--threads", "1", "--quiet", ...options]);
  assert.equal(signal, null, `${name} ended by ${signal}`);
  if (refused) {
    assert.equal(status, 2, `${name}: ${stderr}`);
    assert.match(stderr, refused);
    assert.equal(stderr.trimEnd().split("\n").length, 1, stderr);
    assert.ok(!existsSync(path.join(folder, out, "report.json")), "a refused file leaves no report");
    return;
  }
  assert.equal(status, 0, `${name}: ${stderr}`);
  const report = JSON.parse(readFileSync(path.join(folder, out, "report.json"), "utf8"));
  assert.ok(report.mesh.volume_mm3 > 0 && report.mesh.min_dihedral_deg > 0, `${name}: the tets have no volume`);
  if (volume) assert.ok(Math.abs(report.mesh.volume_mm3 / volume - 1) < 0.01, `${name}: ${report.mesh.volume_mm3} mm³, not ${volume}`);
  if (report.mesh.rebuilt) assert.ok(report.warnings.some((warning) => warning.code === "mesh.rebuilt"), "a rebuild is said");
}

describe("files with defects", { concurrency: 2 }, () => {
  for (const file of defectiveFiles()) test(file.name, () => check(file));
});
