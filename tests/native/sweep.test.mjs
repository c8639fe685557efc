// s3slice sweep: what it writes is what single runs give, triple by triple.
// Needs the native build: the folder of the programs in S3_BUILD, or build/native.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { assertInputError, root, runnerIn, s3slice, testFolder } from "./program.mjs";

const folder = testFolder("sweep");
const { run, runWell } = runnerIn(folder);
const bridge = ["--config", path.join(root, "models/bridge.job.json"), "--mesh.target_tets", "3000"];
const coarse = ["--nozzle.diameter", "3"]; // few layers: the strain of a triple in a second

const read = (...parts) => readFileSync(path.join(folder, ...parts), "utf8");
const json = (...parts) => JSON.parse(read(...parts));

/** Rows of sweep.csv as objects; empty fields are null, numbers are numbers. */
function rowsOf(name) {
  const [head, ...lines] = read(name, "sweep.csv").trimEnd().split("\n");
  const keys = head.split(",");
  return lines.map((line) => {
    const fields = line.match(/("([^"]|"")*"|[^,]*)(,|$)/g).slice(0, keys.length).map((field) => field.replace(/,$/, ""));
    assert.equal(fields.length, keys.length, line);
    const value = (text) => (text === "" ? null : text.startsWith('"') ? text.slice(1, -1).replaceAll('""', '"') : Number.isNaN(Number(text)) ? text : Number(text));
    return Object.fromEntries(keys.map((key, i) => [key, value(fields[i])]));
  });
}

const weightFlags = (t) =>
  ["support_free", "strength", "surface_quality"].flatMap((key) => [`--objectives.${key}`, String(t[key])]);
const fieldKeys = ["pi_rad", "support_free_area_percent", "strength_critical_percent", "surface_quality_area_percent",
  "foldovers", "islands", "gouging_pairs", "concave_pairs_over_20deg"];

test("a row is what a run with these weights gives, strain included", () => {
  const weights = "1,0,0; 0.7,0.3,0;0.2,0.5,0.3";
  runWell("sweep", ...bridge, ...coarse, "-o", "list", "--quiet", "--strain", "--weights", weights, "--threads", "2");
  assert.deepEqual(readdirSync(path.join(folder, "list")).sort(), ["sweep.csv", "sweep.json", "sweep.svg"]);
  const [planar, ...rows] = rowsOf("list");
  assert.deepEqual(rows.map((r) => [r.support_free, r.strength, r.surface_quality]), [[1, 0, 0], [0.7, 0.3, 0], [0.2, 0.5, 0.3]]);
  // The second comes after another triple, the third shares nothing with a fresh run but its weights.
  for (const row of rows.slice(1)) {
    runWell("run", ...bridge, ...coarse, "-o", "single", "--quiet", ...weightFlags(row), "--threads", "1");
    const report = json("single", "report.json");
    for (const key of fieldKeys) assert.equal(row[key], report.curved[key], key);
    for (const key of ["max", "p999", "mean"]) {
      assert.equal(row[`strain_${key}`], report.curved.strain[key], key);
      assert.equal(planar[`strain_${key}`], report.planar.strain[key], `planar ${key}`);
    }
    for (const key of fieldKeys.slice(1)) assert.equal(planar[key], report.planar[key], `planar ${key}`);
  }
  const table = json("list", "sweep.json");
  assert.equal(table.asked, 3);
  assert.equal(table.ended, 3);
  table.triples.forEach((triple, i) => {
    assert.deepEqual(Object.values(triple.weights), [rows[i].support_free, rows[i].strength, rows[i].surface_quality]);
    for (const key of [...fieldKeys, "strain_max", "cpu_s"]) assert.equal(triple[key], rows[i][key], key);
    assert.equal(triple.error, null);
  });
  assert.equal(table.job.nozzle.diameter, 3);
  const svg = read("list", "sweep.svg");
  assert.match(svg, /^<svg [\s\S]*<\/svg>\n$/);
  for (const title of ["Π", "SF,", "SR,", "SQ,", "strain, mean"]) assert.ok(svg.includes(title), title);
  for (const row of rows) assert.ok(svg.includes(`>${row.support_free_area_percent.toFixed(2)}<`));
});

test("the default is the triangle in quarters, up to the field; it costs less than eight runs", () => {
  const { stdout, stderr } = runWell("sweep", ...bridge, ...coarse, "-o", "grid", "--threads", "1");
  const [planar, ...rows] = rowsOf("grid");
  assert.equal(rows.length, 15);
  const places = new Set(rows.map((r) => `${r.support_free},${r.strength},${r.surface_quality}`));
  assert.equal(places.size, 15);
  for (const row of rows) {
    assert.equal(row.support_free + row.strength + row.surface_quality, 1);
    assert.equal(row.strain_max, null);
    for (const key of fieldKeys) assert.notEqual(row[key], null, key);
  }
  assert.equal(planar.pi_rad, null);
  // The corner of SF overhangs least, that of SR runs best along the tension.
  const best = (key) => rows.reduce((a, b) => (b[key] > a[key] ? b : a));
  assert.ok(best("support_free_area_percent").support_free > 0);
  assert.ok(best("strength_critical_percent").strength > 0);
  const hexagons = read("grid", "sweep.svg").match(/<polygon points="(\S+ ){6}"/g);
  assert.equal(hexagons.length, 4 * 15);
  assert.equal(stderr.match(/^SF .* CPU s$/gm).length, 15);
  assert.match(stdout, /planar layers/);

  runWell("run", ...bridge, ...coarse, "-o", "whole", "--quiet", "--threads", "1");
  const cpu = Object.values(json("whole", "report.json").cpu_s).reduce((a, b) => a + (b ?? 0), 0);
  const { shared_cpu_s, triples } = json("grid", "sweep.json");
  const sweep = triples.reduce((sum, t) => sum + t.cpu_s, shared_cpu_s + planar.cpu_s);
  assert.ok(sweep < 8 * cpu, `${sweep} s against runs of ${cpu} s`);
});

test("what stops a triple stands in its row, and the others go on", () => {
  // A layer of 40 mm is more than the part is high: there are fields but no prints.
  const result = run("sweep", ...bridge, "-o", "failing", "--weights", "1,0,0;0.5,0.5,0", "--strain", "--nozzle.diameter", "400");
  assert.equal(result.status, 3, result.stderr);
  const rows = rowsOf("failing");
  assert.equal(rows.length, 3);
  for (const row of rows) {
    assert.match(row.error, /no layer.*input\.scale/);
    assert.equal(row.strain_max, null);
    assert.notEqual(row.support_free_area_percent, null);
  }
  assert.match(json("failing", "sweep.json").triples[1].error, /no layer/);
});

test("wrong input ends with code 2 before anything is written", () => {
  const sweep = (...args) => run("sweep", ...bridge, "-o", "none", ...args);
  assertInputError(sweep("--weights", "1,0"), "1,0", "2 numbers", "SF,SR,SQ");
  assertInputError(sweep("--weights", "1,0,2"), "2 is not between 0 and 1");
  assertInputError(sweep("--weights", "1,0,nan"), "nan");
  assertInputError(sweep("--weights", "0,0,0"), "all weights are 0");
  assertInputError(sweep("--weights", " ; "), "no triple");
  assertInputError(sweep("--grid", "0"), "grid");
  assertInputError(sweep("--grid", "3", "--weights", "1,0,0"), "--weights");
  assertInputError(sweep("--objectives.strength", "0.5"), "objectives.strength", "--weights");
  assertInputError(sweep("--objective.gama", "3"), "objectives.gamma");
  assertInputError(run("sweep", ...bridge), "-o");
  const plain = path.join(root, "models/bridge.stl");
  assertInputError(run("sweep", plain, "-o", "none"), "strength.load_case");
  assertInputError(run("sweep", plain, "-o", "none", "--weights", "1,0,0", "--strain"), "--strain", "strength.load_case");
  assert.ok(!existsSync(path.join(folder, "none")));
});

test("without a stress, triples without strength still have their figures", () => {
  runWell("sweep", path.join(root, "models/bridge.stl"), "-o", "plain", "--quiet", "--mesh.target_tets", "3000",
    "--weights", "1,0,0", "--weights", "0.5,0,0.5", "--weights", "1,0,0");
  const rows = rowsOf("plain");
  assert.equal(rows.length, 3); // planar and two: a triple given twice runs once
  assert.equal(rows[1].strength_critical_percent, null);
  assert.ok(!read("plain", "sweep.svg").includes("SR,"));
});

test("Ctrl-C keeps the rows that have ended, and results of an earlier run are gone", async () => {
  runWell("run", ...bridge, "-o", "cancelled", "--quiet", "--until", "outer_loop");
  const child = spawn(s3slice, ["sweep", ...bridge, "-o", "cancelled", "--grid", "20"], { cwd: folder });
  let stderr = "";
  let interrupted = false;
  child.stderr.on("data", (data) => {
    stderr += data;
    if (interrupted || (stderr.match(/^SF .* CPU s$/gm) ?? []).length < 2) return;
    interrupted = child.kill("SIGINT");
  });
  const code = await new Promise((resolve) => child.on("close", resolve));
  assert.equal(code, 130, stderr);
  const files = readdirSync(path.join(folder, "cancelled"));
  assert.deepEqual(files.filter((name) => name !== "stress.csv").sort(), ["sweep.csv", "sweep.json", "sweep.svg"]);
  const rows = rowsOf("cancelled");
  assert.ok(rows.length >= 3 && rows.length < 232, `${rows.length} rows`);
  const table = json("cancelled", "sweep.json");
  assert.equal(table.asked, 231);
  assert.equal(table.ended, rows.length - 1);
  assert.equal(table.triples.length, rows.length - 1);
});
