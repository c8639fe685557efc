// Runs every model of the given files and folders and prints one line of a table for each: what is wrong with the file,
// what was repaired, which mesher took it, and how well that went, or the sentence it was refused with.
//   node tests/native/any_mesh.mjs [--until STAGE] [--tets N] [--limit SECONDS] [--jobs N] [--size MM] [--sheet MM] FILE|FOLDER...
// With --size every model is scaled until its longest side has this length, so that models without a unit print.
// With --sheet surfaces that enclose nothing get this thickness.
// Ends with 1 when a run crashed, took too long, or failed with anything but one clear sentence.
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, extname, join } from "node:path";
import { fileURLToPath } from "node:url";

const root = join(dirname(fileURLToPath(import.meta.url)), "..", "..");
const program = process.env.S3SLICE ?? join(root, "build", "native", "s3slice");
const MODELS = new Set([".stl", ".obj", ".off", ".ply", ".3mf", ".msh", ".tet", ".vtu"]);

const options = { until: "", tets: 60000, limit: 300, jobs: 1, size: 0, sheet: 0 };
const places = [];
for (let i = 2; i < process.argv.length; ++i) {
  const key = process.argv[i].replace(/^--/, "");
  if (process.argv[i].startsWith("--")) options[key] = key === "until" ? process.argv[++i] : Number(process.argv[++i]);
  else places.push(process.argv[i]);
}

/** @returns {string[]} the models below a path, sorted */
function modelsBelow(path) {
  if (!statSync(path).isDirectory()) return [path];
  return readdirSync(path)
    .sort()
    .flatMap((name) => {
      const inside = join(path, name);
      if (statSync(inside).isDirectory()) return modelsBelow(inside);
      return MODELS.has(extname(name).toLowerCase()) ? [inside] : [];
    });
}

/** @returns {Promise<{code: number|null, stdout: string, stderr: string, seconds: number}>} code null: killed for its time */
function run(args) {
  return new Promise((resolve) => {
    const start = Date.now();
    // CPU seconds: on a busy machine the clock says nothing.
    const limited = ["-c", `ulimit -t ${Math.ceil(options.limit)}; exec "$0" "$@"`, program, ...args];
    const child = spawn("/bin/sh", limited, { stdio: ["ignore", "pipe", "pipe"] });
    let stdout = "", stderr = "";
    child.stdout.on("data", (data) => (stdout += data));
    child.stderr.on("data", (data) => (stderr += data));
    child.on("close", (code) => {
      resolve({ code, stdout, stderr, seconds: (Date.now() - start) / 1000 });
    });
  });
}

function defectsOf(inspected) {
  if (inspected === null) return "";
  if (inspected.is_volume) return "volume mesh";
  const names = {
    open_edges: "open edges",
    nonmanifold_edges: "crowded edges",
    inconsistent_edges: "edges with opposite faces",
    nonmanifold_vertices: "touching vertices",
    degenerate_triangles: "flat triangles",
    duplicate_triangles: "doubled triangles",
    self_intersections: "crossing pairs",
  };
  const found = Object.entries(names)
    .filter(([key]) => inspected[key]?.count > 0)
    .map(([key, name]) => `${inspected[key].count} ${name}`);
  const inverted = inspected.shells.filter((shell) => shell.inverted).length;
  if (inverted > 0) found.push(`${inverted} inverted shells`);
  return found.join(", ") || "none";
}

const fixed = (x, digits) => (x === null || x === undefined ? "–" : x.toFixed(digits));

async function measure(model) {
  const out = mkdtempSync(join(tmpdir(), "any-mesh-"));
  try {
    const inspection = await run(["inspect", model, "--json"]);
    const inspected = inspection.code === 0 ? JSON.parse(inspection.stdout) : null;
    if (inspection.code !== 0 && inspection.code !== 2)
      return { model: basename(model), defects: "", code: inspection.code, good: false, sentence: "inspect failed: " + inspection.stderr.trim(), seconds: inspection.seconds };
    const args = ["run", model, "-o", out, "--mesh.target_tets", String(options.tets), "--threads", "1", "--quiet"];
    if (options.size > 0 && inspected?.size_mm) args.push("--input.scale", String(options.size / Math.max(...inspected.size_mm)));
    if (options.sheet > 0) args.push("--input.sheet_thickness", String(options.sheet));
    if (options.until) args.push("--until", options.until);
    const result = await run(args);
    const row = { model: basename(model), defects: defectsOf(inspected), code: result.code, good: true };
    if (result.code !== 0) {
      const lines = result.stderr.trim().split("\n");
      row.sentence = lines.at(-1);
      row.good = (result.code === 2 || result.code === 3) && !/internal/.test(row.sentence);
      if (result.code === null) row.sentence = `took more than ${options.limit} CPU seconds`;
      row.seconds = result.seconds;
      return row;
    }
    const report = JSON.parse(readFileSync(join(out, "report.json"), "utf8"));
    const cpu = Object.values(report.cpu_s).reduce((sum, seconds) => sum + (seconds ?? 0), 0);
    const distance = report.mesh.rebuilt?.distance_mm;
    Object.assign(row, {
      repairs: report.input.repairs.join("; ") || "none",
      reason: report.mesh.fallback,
      backend: report.mesh.backend,
      p95: distance ? Math.max(distance.to_input.p95_percent, distance.from_input.p95_percent) : null,
      max: distance ? Math.max(distance.to_input.max_percent, distance.from_input.max_percent) : null,
      ratio: report.mesh.volume_mm3 / report.input.volume_mm3,
      tets: report.mesh.tets,
      dihedral: report.mesh.min_dihedral_deg,
      foldovers: report.curved.foldovers,
      warnings: report.warnings.map((warning) => warning.code),
      seconds: cpu,
    });
    row.good = cpu < options.limit;
    return row;
  } finally {
    rmSync(out, { recursive: true, force: true });
  }
}

function line(row) {
  if (row.code !== 0) return `| ${row.model} | ${row.defects} | exit ${row.code}: ${row.sentence} | | | | | | | ${fixed(row.seconds, 1)} |`;
  const repair = row.reason ? `${row.repairs} → ${row.reason}` : row.repairs;
  const distance = row.p95 === null ? "0" : `${fixed(row.p95, 3)} (max ${fixed(row.max, 2)})`;
  return (
    `| ${row.model} | ${row.defects} | ${repair} | ${row.backend} | ${distance} | ${fixed(row.ratio, 4)} | ${row.tets} | ` +
    `${fixed(row.dihedral, 1)} | ${row.foldovers ?? "–"} | ${fixed(row.seconds, 1)} |`
  );
}

const models = places.flatMap(modelsBelow);
console.log("| file | defects | repair | mesher | distance p95, % of diagonal | volume ratio | tets | min dihedral, deg | foldovers | CPU s |");
console.log("|---|---|---|---|---|---|---|---|---|---|");
const rows = [];
const queue = [...models];
await Promise.all(
  Array.from({ length: options.jobs }, async () => {
    while (queue.length > 0) {
      const row = await measure(queue.shift());
      rows.push(row);
      console.log(line(row));
    }
  }),
);
const through = rows.filter((row) => row.code === 0).length;
const bad = rows.filter((row) => !row.good);
console.log(`\n${rows.length} models, ${through} through, ${rows.length - through} refused, ${bad.length} bad: ${bad.map((row) => row.model).join(", ")}`);
process.exitCode = bad.length > 0 ? 1 : 0;
