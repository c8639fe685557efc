// s3slice end to end, as a person uses it: files in, files out, exit codes and messages.
// Needs the native build: the folder of the programs in S3_BUILD, or build/native.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { assertInputError, root, runnerIn, s3slice, testFolder } from "./program.mjs";

const folder = testFolder("cli");
const { run, runWell } = runnerIn(folder);

/** A grid of tets over a box; above z = 2 it leans over by 50°. Six tets a cell. */
function leaningBlock(nx = 4, ny = 3, nz = 5) {
  const id = (i, j, k) => (k * (ny + 1) + j) * (nx + 1) + i;
  const vertices = [];
  for (let k = 0; k <= nz; ++k)
    for (let j = 0; j <= ny; ++j)
      for (let i = 0; i <= nx; ++i) {
        const z = (10 * k) / nz;
        vertices.push([(8 * i) / nx + 1.2 * Math.max(0, z - 2), (6 * j) / ny, z]);
      }
  const tets = [];
  const orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
  for (let k = 0; k < nz; ++k)
    for (let j = 0; j < ny; ++j)
      for (let i = 0; i < nx; ++i)
        for (const order of orders) {
          const at = [i, j, k];
          const tet = [id(...at)];
          for (const axis of order) {
            at[axis] += 1;
            tet.push(id(...at));
          }
          tets.push(tet);
        }
  return { vertices, tets };
}

function tetText({ vertices, tets }) {
  const rows = [`${vertices.length} vertices`, `${tets.length} tets`];
  for (const v of vertices) rows.push(v.join(" "));
  for (const t of tets) rows.push(`4 ${t.join(" ")}`);
  return rows.join("\n") + "\n";
}

/** The corners of a box as an ASCII STL of twelve triangles, outward. */
function boxStl(size) {
  const corner = (c) => [0, 1, 2].map((axis) => ((c >> axis) & 1) * size[axis]).join(" ");
  const quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  let text = "solid box\n";
  for (const [a, b, c, d] of quads)
    for (const triangle of [[a, b, c], [a, c, d]])
      text += `facet normal 0 0 0\nouter loop\n${triangle.map((c) => `vertex ${corner(c)}\n`).join("")}endloop\nendfacet\n`;
  return text + "endsolid box\n";
}

function write(name, content) {
  writeFileSync(path.join(folder, name), content);
  return name;
}

const read = (...parts) => readFileSync(path.join(folder, ...parts));
const json = (...parts) => JSON.parse(read(...parts));

/** Every file below a folder by its relative name. */
function filesOf(name, prefix = "") {
  const files = {};
  for (const entry of readdirSync(path.join(folder, name), { withFileTypes: true })) {
    const relative = prefix + entry.name;
    if (entry.isDirectory()) Object.assign(files, filesOf(path.join(name, entry.name), `${relative}/`));
    else files[relative] = read(name, entry.name);
  }
  return files;
}

/** What must not depend on the clock, the machine or the number of threads. */
function withoutMeasurements(report) {
  const { timings_s, cpu_s, threads, peak_memory_mb, ...rest } = report;
  return rest;
}

function assertSameResults(one, other) {
  const a = filesOf(one);
  const b = filesOf(other);
  assert.deepEqual(Object.keys(a).sort(), Object.keys(b).sort());
  for (const name of Object.keys(a))
    if (name !== "report.json") assert.ok(a[name].equals(b[name]), `${name} differs`);
  assert.deepEqual(withoutMeasurements(JSON.parse(a["report.json"])), withoutMeasurements(JSON.parse(b["report.json"])));
}

const metricKeys = [
  "support_free_area_percent", "support_free_mean_violation_deg", "surface_quality_area_percent",
  "strength_critical_percent", "pi_rad", "foldovers", "gouging_pairs", "concave_pairs_over_20deg", "islands", "layers",
  "components", "thickness_mm", "thickness_outside_area_percent", "path_length_mm", "coverage_percent",
  "overlap_percent", "surface_error_mm", "strain", "support_volume_mm3", "material_g", "print_time_s",
];
const timingKeys = [
  "repair", "tetrahedralize", "fea", "lpd_projection", "quaternion", "deformation", "refinement", "foldover", "layers",
  "toolpaths", "motion", "export", "total",
];

test("a tet mesh becomes layers, waypoints, a program and a report", () => {
  write("block.tet", tetText(leaningBlock()));
  const { stdout } = runWell("run", "block.tet", "-o", "out");
  assert.match(stdout, /support free/);
  assert.match(stdout, /curved\s+planar/);
  const files = filesOf("out");
  for (const name of ["report.json", "job.json", "fields.vtu", "waypoints.csv", "layers/0000.ply", "support_free.svg"])
    assert.ok(name in files, `${name} is missing`);
  for (const name of Object.keys(files)) assert.ok(!name.endsWith(".part"), `${name} was left behind`);

  const report = json("out", "report.json");
  assert.match(report.s3slice, /^\d+\.\d+\.\d+$/);
  assert.equal(report.mesh.tets, 360);
  assert.equal(report.mesh.vertices, 120);
  for (const key of timingKeys) assert.ok(key in report.timings_s, key);
  for (const kind of ["curved", "planar"]) {
    for (const key of metricKeys) assert.ok(key in report[kind], `${kind}.${key}`);
    assert.equal(report[kind].strain.max, null); // not computed
    assert.equal(report[kind].strength_critical_percent, null);
  }
  assert.equal(report.curved.foldovers, 0);
  assert.ok(report.outer_iterations >= 1 && report.pi_rad.length >= 1);
  assert.ok(report.curved.support_free_area_percent > report.planar.support_free_area_percent);
  assert.ok(report.peak_memory_mb > 1);

  const layers = Object.keys(files).filter((name) => name.startsWith("layers/"));
  assert.equal(layers.length, report.curved.components);
  for (const name of layers) assert.equal(files[name].subarray(0, 4).toString(), "ply\n");
  const rows = files["waypoints.csv"].toString().trimEnd().split("\n");
  const data = rows.filter((row) => !row.startsWith("#"));
  assert.equal(data[0], "layer,path,kind,x,y,z,nx,ny,nz,tx,ty,tz,width,height,e,speed,travel");
  for (const row of data.slice(1)) assert.equal(row.split(",").length, 17);
  for (const name of Object.keys(files).filter((file) => file.endsWith(".svg")))
    assert.match(files[name].toString(), /^<svg [\s\S]*<\/svg>\n$/);
});

test("job.json repeats a run bit for bit, whatever the number of threads", () => {
  write("block.tet", tetText(leaningBlock()));
  runWell("run", "block.tet", "-o", "first", "--threads", "1", "--quiet", "--toolpath.spacing", "1.5");
  runWell("run", "--config", "first/job.json", "-o", "second", "--threads", "3", "--quiet");
  assertSameResults("first", "second");
  assert.equal(json("second", "job.json").toolpath.spacing, 1.5);
  const before = filesOf("second");
  runWell("run", "--config", "second/job.json", "--quiet"); // where it was
  for (const [name, bytes] of Object.entries(filesOf("second")))
    if (name !== "report.json") assert.ok(bytes.equals(before[name]), `${name} differs`);
});

test("a surface becomes tets first", () => {
  write("box.stl", boxStl([10, 8, 6]));
  runWell("run", "box.stl", "-o", "box", "--mesh.target_tets", "2000", "--until", "outer_loop");
  const report = json("box", "report.json");
  assert.equal(report.input.triangles, 12);
  assert.ok(Math.abs(report.input.volume_mm3 - 480) < 1e-6);
  assert.ok(report.mesh.tets > 1000 && report.mesh.tets < 4000, `${report.mesh.tets} tets`);
});

test("several bodies are printed on one plate", () => {
  runWell("run", path.join(root, "models/trio.stl"), "-o", "trio", "--mesh.target_tets", "9000", "--nozzle.diameter", "2");
  const report = json("trio", "report.json");
  assert.equal(report.curved.islands, 0);
  assert.equal(report.curved.foldovers, 0);
  // So few tets need a simpler surface, which is said; no body floats.
  assert.deepEqual(report.warnings.filter(({ code }) => code.startsWith("mesh.") && code !== "mesh.rebuilt"), []);
  const rows = read("trio", "waypoints.csv").toString().trimEnd().split("\n");
  const points = rows.filter((row) => /^\d/.test(row)).map((row) => row.split(","));
  // An arch, a drop and a block: their places along x, their heights.
  const bodies = [[-40, -8, 16], [-6, 10, 26], [18, 36, 20]];
  for (const [low, high, top] of bodies) {
    const own = points.filter((row) => row[16] === "0" && row[3] > low - 1 && row[3] < high + 1);
    assert.ok(own.length > 100, `${own.length} points between x = ${low} and ${high}`);
    const z = own.map((row) => Number(row[5]));
    assert.ok(z.reduce((a, b) => Math.max(a, b)) > top - 2.5, "printed to its top");
    assert.ok(z.reduce((a, b) => Math.min(a, b)) < 2, "begun on the plate");
  }
  const between = points.filter((row) => row[16] === "0" && (row[3] > -7.5 && row[3] < -6.5 || row[3] > 11 && row[3] < 17));
  assert.equal(between.length, 0, "nothing is printed between the bodies");
});

test("0 tets takes what the thinnest wall needs; too few are named with the target", () => {
  write("plate.stl", boxStl([12, 9, 1]));
  runWell("run", "plate.stl", "-o", "auto", "--mesh.target_tets", "0", "--until", "tetrahedralize");
  const automatic = json("auto", "report.json");
  assert.ok(automatic.mesh.tets > 25000 && automatic.mesh.tets < 36000, `${automatic.mesh.tets} tets`);
  assert.deepEqual(automatic.warnings, []);
  runWell("run", "plate.stl", "-o", "few", "--mesh.target_tets", "300", "--until", "tetrahedralize");
  const thin = json("few", "report.json").warnings.find(({ code }) => code === "tetrahedralize.thin_wall");
  assert.match(thin.message, /wall of 1 mm near .*mesh\.target_tets of about 13000/);
  assert.equal(thin.where.length, 1);
  assertInputError(run("run", "plate.stl", "-o", "few", "--mesh.target_tets", "99"), "mesh.target_tets", "100");
});

test("a search for the orientation lists what it found, and the first is taken", () => {
  write("tower.stl", boxStl([4, 6, 60]));
  const inspected = JSON.parse(runWell("inspect", "tower.stl", "--json").stdout);
  assert.equal(inspected.orientations.length, 5);
  runWell("run", "tower.stl", "-o", "lying", "--input.rotate", "auto", "--mesh.target_tets", "500", "--until", "tetrahedralize");
  const { orientations } = json("lying", "report.json").input;
  assert.deepEqual(orientations, inspected.orientations);
  assert.equal(orientations[0].stable, true);
  assert.ok(Math.abs(orientations[0].contact_area_mm2 - 360) < 1e-3);
  assert.ok(Math.abs(orientations[0].height_mm - 4) < 1e-4);
  assert.match(runWell("inspect", "tower.stl").stdout, /overhang mm2 .*stable\n.* yes\n/);
  runWell("run", "tower.stl", "-o", "flat", "--input.rotate", "flat", "--mesh.target_tets", "500", "--until", "tetrahedralize");
  assert.ok(Math.abs(json("flat", "report.json").input.orientations[0].height_mm - 4) < 1e-4);
});

test("--until stops after a stage; what was not computed is null, files of an earlier run go", () => {
  write("block.tet", tetText(leaningBlock()));
  runWell("run", "block.tet", "-o", "until", "--quiet");
  runWell("run", "block.tet", "-o", "until", "--quiet", "--until", "outer_loop");
  const names = Object.keys(filesOf("until"));
  assert.deepEqual(names.sort(), ["fields.vtu", "job.json", "report.json"]);
  const report = json("until", "report.json");
  assert.equal(report.timings_s.layers, null);
  assert.equal(report.curved.layers, null);
  assert.equal(report.curved.foldovers, null);
  assertInputError(run("run", "block.tet", "-o", "until", "--until", "lunch"), "lunch", "outer_loop");
});

test("flags override files, a later file overrides an earlier one", () => {
  write("block.tet", tetText(leaningBlock()));
  write("a.json", JSON.stringify({ model: "block.tet", nozzle: { diameter: 0.7 }, toolpath: { spacing: 3 } }));
  write("b.json", JSON.stringify({ nozzle: { diameter: 0.9 } }));
  runWell("run", "--config", "a.json", "--config", "b.json", "--objectives.gamma", "15", "-o", "over", "--until", "mesh");
  const job = json("over", "job.json");
  assert.equal(job.nozzle.diameter, 0.9);
  assert.equal(job.toolpath.spacing, 3);
  assert.equal(job.objectives.gamma, 15);
  assert.equal(job.model, path.join(folder, "block.tet"));
});

test("wrong input ends with code 2 and one line that says what, where and what to do", () => {
  write("block.tet", tetText(leaningBlock()));
  write("noise.stl", "\u0001\u0002 this is no model");
  write("empty.off", "");
  assertInputError(run("run", "missing.stl", "-o", "x"), "missing.stl");
  assertInputError(run("run", "noise.stl", "-o", "x"), "noise.stl");
  assertInputError(run("run", "empty.off", "-o", "x"), "empty.off");
  assertInputError(run("run", "block.tet", "-o", "x", "--deform.rigidty", "1"), "deform.rigidty", "deform.rigidity");
  assertInputError(run("run", "block.tet", "-o", "x", "--objectives.alpha", "120"), "objectives.alpha", "120", "0 to 90");
  assertInputError(run("run", "block.tet", "-o", "x", "--objectives.alpha", "steep"), "objectives.alpha", "steep");
  assertInputError(run("run", "block.tet", "-o", "x", "--machine", "lathe"), "lathe");
  assertInputError(run("run", "block.tet"), "-o");
  assertInputError(run("run", "-o", "x"), "model");
  write("bad.json", "{ nozzle: ");
  assertInputError(run("run", "block.tet", "-o", "x", "--config", "bad.json"), "bad.json");
  write("typo.json", '{"layers": {"min_thicknes": 0.3}}');
  assertInputError(run("run", "block.tet", "-o", "x", "--config", "typo.json"), "typo.json", "layers.min_thickness");
  assertInputError(run("run", "block.tet", "-o", "x", "--objectives.strength", "0.5"), "strength.stress_file");
  write("sheet.stl", boxStl([10, 8, 6]).match(/^solid[^\n]*\n|facet[\s\S]*?endfacet\n|endsolid[\s\S]*$/g).filter((_, i, all) => i < 3 || i === all.length - 1).join(""));
  assertInputError(run("run", "sheet.stl", "-o", "x"), "open sheet");
  assertInputError(run("evaluate", "nowhere"), "nowhere");
  assertInputError(run("paint"), "--help");
  write("file", "");
  assertInputError(run("run", "block.tet", "-o", "file/below", "--until", "mesh", "--quiet"), "file/below");
  assert.ok(!existsSync(path.join(folder, "x")), "a run that never began made its folder");
});

test("Ctrl-C ends with 130, and the files of finished stages are whole", async () => {
  write("large.tet", tetText(leaningBlock(24, 18, 30)));
  const child = spawn(s3slice, ["run", "large.tet", "-o", "cancelled"], { cwd: folder });
  let stderr = "";
  let interrupted = false;
  child.stderr.on("data", (data) => {
    stderr += data;
    if (interrupted || !/^outer_loop /m.test(stderr)) return;
    interrupted = child.kill("SIGINT"); // a second one would end it without ceremony
  });
  const code = await new Promise((resolve) => child.on("close", resolve));
  assert.equal(code, 130, stderr);
  assert.match(stderr, /cancelled/);
  const files = filesOf("cancelled");
  assert.ok(!("report.json" in files));
  for (const name of Object.keys(files)) assert.ok(!name.endsWith(".part"), name);
  if ("fields.vtu" in files) assert.match(files["fields.vtu"].toString("latin1"), /<\/VTKFile>\n$/);
  assert.ok("job.json" in files);
});

test("a profile may ask for the authors' waypoints: a file for each layer piece, y up", () => {
  write("block.tet", tetText(leaningBlock()));
  write("arm.json", JSON.stringify({ inherits: "table-bc-duet", programs: ["authors-waypoints"] }));
  runWell("run", "block.tet", "-o", "authors", "--quiet", "--machine", "arm.json");
  const files = filesOf("authors");
  assert.ok(!("program.gcode" in files), "a program that nobody asked for");
  const pieces = json("authors", "report.json").curved.components;
  const points = [];
  for (let k = 0; k < pieces; ++k)
    points.push(...files[`authors-waypoints/${k}.txt`].toString().trimEnd().split("\n").map((line) => line.split(" ").map(Number)));
  assert.ok(!(`authors-waypoints/${pieces}.txt` in files));
  const extruded = files["waypoints.csv"].toString().trimEnd().split("\n").filter((row) => !/^(#|layer)/.test(row))
    .map((row) => row.split(",")).filter((row) => Number(row[12]) > 0);
  assert.equal(points.length, extruded.length);
  points.forEach(([x, y, z, nx, ny, nz], i) => {
    const [px, py, pz, mx, my, mz] = extruded[i].slice(3, 9).map(Number);
    // Their axes: y up; their normals point into the part.
    for (const [a, b] of [[x, px], [-z, py], [y, pz], [-nx, mx], [nz, my], [-ny, mz]]) assert.ok(Math.abs(a - b) < 2e-5, `point ${i}`);
  });
  write("odd.json", JSON.stringify({ inherits: "cartesian", programs: ["poem.txt"] }));
  assertInputError(run("run", "block.tet", "-o", "odd", "--quiet", "--machine", "odd.json"), "poem.txt", "authors-waypoints");
});

test("inspect reports a sheet and says why it would be refused", () => {
  writeFileSync(path.join(folder, "sheet.off"), "OFF\n4 2 0\n0 0 0\n30 0 0\n30 30 0\n0 30 0\n3 0 1 2\n3 0 2 3\n");
  const report = JSON.parse(runWell("inspect", "sheet.off", "--json").stdout);
  assert.equal(report.open_edges.count, 4);
  assert.match(report.refused, /open sheet.*input\.sheet_thickness/);
});

test("the schema lists every parameter that a job file holds", () => {
  const schema = JSON.parse(runWell("schema").stdout);
  write("block.tet", tetText(leaningBlock()));
  runWell("run", "block.tet", "-o", "schema", "--until", "mesh");
  const check = (job, node, key) => {
    if (node.type !== "object") {
      assert.equal(node.key, key);
      for (const field of ["unit", "default", "description"]) assert.ok(field in node, `${key}: ${field}`);
      return;
    }
    assert.deepEqual(Object.keys(job).sort(), Object.keys(node.properties).sort());
    for (const name of Object.keys(job)) check(job[name], node.properties[name], key ? `${key}.${name}` : name);
  };
  check(json("schema", "job.json"), schema, "");
});

test("a load case becomes stress, layers along it and the strain of the print", () => {
  write("block.tet", tetText(leaningBlock()));
  const load = {
    conditions: [
      { region: "plate", fixed: true },
      { region: { half_space: { point: [0, 0, 9.9], normal: [0, 0, 1] } }, force: [30, 0, 0] },
    ],
  };
  write("block.load.json", JSON.stringify(load));
  const flags = ["--strength.load_case", "block.load.json", "--objectives.strength", "0.5"];
  runWell("run", "block.tet", "-o", "loaded", "--quiet", ...flags);
  const report = json("loaded", "report.json");
  for (const kind of ["curved", "planar"]) {
    const { max, p999, mean } = report[kind].strain;
    assert.ok(mean > 0 && p999 >= mean && max >= p999, kind);
    assert.ok(report[kind].strength_critical_percent >= 0);
  }
  const vtu = read("loaded", "fields.vtu").toString();
  for (const name of ["tau_max", "sigma_max", "critical", "stress"]) assert.match(vtu, new RegExp(`Name="${name}"`));
  const rows = read("loaded", "stress.csv").toString().trimEnd().split("\n");
  assert.equal(rows.length, 361);
  const again = JSON.parse(runWell("evaluate", "loaded").stdout);
  assert.deepEqual(Object.keys(again.curved.strain), ["max", "p999", "mean"]);
  assert.ok(Math.abs(again.curved.strain.mean / report.curved.strain.mean - 1) < 0.02);

  runWell("run", "block.tet", "-o", "imported", "--quiet", "--until", "objectives", "--objectives.strength", "0.5",
    "--strength.stress_file", "loaded/stress.csv");
  load.conditions[0].fixed = "z";
  write("loose.json", JSON.stringify(load));
  assertInputError(run("run", "block.tet", "-o", "y", "--quiet", "--strength.load_case", "loose.json"), "slide along x");
  write("typo.json", JSON.stringify({ condition: [] }));
  assertInputError(run("run", "block.tet", "-o", "y", "--strength.load_case", "typo.json"), "typo.json", "condition");
  assertInputError(run("run", "block.tet", "-o", "y", "--strength.load_case", "none.json"), "none.json");
});

test("surface quality can be asked of a region, and evaluate finds its figure again", () => {
  write("block.tet", tetText(leaningBlock()));
  // The roof: 48 mm², flat in planar layers.
  write("roof.json", JSON.stringify({ region: { plane: { point: [0, 0, 10], normal: [0, 0, 1] } } }));
  runWell("run", "block.tet", "-o", "roof", "--quiet", "--objectives.surface_quality", "0.5", "--objectives.surface_region", "roof.json");
  const report = json("roof", "report.json");
  assert.ok(Math.abs(report.planar.surface_quality_region_percent - 100) < 1e-9);
  assert.ok(report.planar.surface_quality_area_percent < 99);
  assert.equal(json("roof", "job.json").objectives.surface_region, path.join(folder, "roof.json"));
  const again = JSON.parse(runWell("evaluate", "roof").stdout);
  assert.ok(Math.abs(again.curved.surface_quality_region_percent - report.curved.surface_quality_region_percent) < 1e-6);
  write("typo.json", JSON.stringify({ regions: {} }));
  assertInputError(run("run", "block.tet", "-o", "y", "--objectives.surface_region", "typo.json"), "typo.json", "region");
  assertInputError(run("run", "block.tet", "-o", "y", "--strength.critical_region", "none.json"), "none.json");
});

test("the bundled load cases hold and load their models", () => {
  for (const name of ["bridge", "bracket"]) {
    const job = path.join(root, "models", `${name}.job.json`);
    runWell("run", "--config", job, "-o", name, "--quiet", "--until", "fea", "--mesh.target_tets", "20000");
    const largest = read(name, "stress.csv").toString().trimEnd().split("\n").slice(1).map((row) => Number(row.split(",")[1]));
    const peak = largest.reduce((a, b) => Math.max(a, b), 0);
    assert.ok(peak > 0.5 && peak < 50, `${name}: ${peak} MPa`); // something to do for SR, and nothing breaks
  }
});

test("evaluate finds the same figures in the files as the run did", () => {
  write("block.tet", tetText(leaningBlock()));
  runWell("run", "block.tet", "-o", "evaluated", "--quiet");
  const report = json("evaluated", "report.json");
  const again = JSON.parse(runWell("evaluate", "evaluated").stdout);
  for (const key of ["support_free_area_percent", "surface_quality_area_percent", "pi_rad", "foldovers", "gouging_pairs",
    "concave_pairs_over_20deg", "islands", "layers", "components", "support_volume_mm3"]) {
    assert.ok(Math.abs(again.curved[key] - report.curved[key]) <= 1e-6 * (1 + Math.abs(report.curved[key])), key);
  }
  for (const key of ["path_length_mm", "material_g", "print_time_s"])
    assert.ok(Math.abs(again.curved[key] / report.curved[key] - 1) < 0.02, `${key}: ${again.curved[key]}`);
  assert.ok(Math.abs(again.curved.coverage_percent - report.curved.coverage_percent) < 2);
  assert.ok(Math.abs(again.curved.surface_error_mm.avg - report.curved.surface_error_mm.avg) < 0.01);
});

test("inspect reports on good and bad models", () => {
  write("box.stl", boxStl([10, 8, 6]));
  const box = JSON.parse(runWell("inspect", "box.stl", "--json").stdout);
  assert.equal(box.valid, true);
  assert.ok(Math.abs(box.volume_mm3 - 480) < 1e-6);
  write("open.stl", boxStl([10, 8, 6]).replace(/facet[\s\S]*?endfacet\n/, ""));
  const open = JSON.parse(runWell("inspect", "open.stl", "--json").stdout);
  assert.equal(open.valid, false);
  assert.equal(open.open_edges.count, 3);
  write("block.tet", tetText(leaningBlock()));
  assert.match(runWell("inspect", "block.tet").stdout, /tets\s+360/);
});
