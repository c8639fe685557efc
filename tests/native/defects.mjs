// Files with every kind of defect that users' models have, each alone and combined, made from the bundled models.
//   node tests/native/defects.mjs FOLDER        writes them, for any_mesh.mjs
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");

/** A generator of numbers in [0, 1), the same on every machine (mulberry32). */
function random(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

// --- surfaces: { vertices: [[x, y, z]…], triangles: [[a, b, c]…] } ---------------------------------------------------

/** A binary STL with equal corners made one vertex. */
export function readStl(file) {
  const bytes = readFileSync(file);
  const indices = new Map(), vertices = [], triangles = [];
  for (let t = 0; t < bytes.readUInt32LE(80); ++t) {
    triangles.push([0, 1, 2].map((corner) => {
      const point = [0, 4, 8].map((b) => bytes.readFloatLE(84 + 50 * t + 12 + 12 * corner + b));
      const key = point.join();
      if (!indices.has(key)) indices.set(key, vertices.push(point) - 1);
      return indices.get(key);
    }));
  }
  return { vertices, triangles };
}

/** Volume within a closed surface, mm³. */
export function volume({ vertices, triangles }) {
  return triangles.reduce((sum, corners) => {
    const [a, b, c] = corners.map((v) => vertices[v]);
    return sum + (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
  }, 0);
}

const model = (name) => readStl(path.join(root, "models", `${name}.stl`));
const moved = ({ vertices, triangles }, f) => ({ vertices: vertices.map((p, i) => f(p, i)), triangles });
const kept = ({ vertices, triangles }, f) => ({ vertices, triangles: triangles.filter((t, i) => f(t, i)) });
const flipped = ({ vertices, triangles }, f = () => true) => ({ vertices, triangles: triangles.map((t, i) => (f(t, i) ? [t[0], t[2], t[1]] : t)) });
const with_triangles = ({ vertices, triangles }, more) => ({ vertices, triangles: [...triangles, ...more] });
function together(...surfaces) {
  const all = { vertices: [], triangles: [] };
  for (const { vertices, triangles } of surfaces) {
    const first = all.vertices.length;
    all.vertices.push(...vertices);
    all.triangles.push(...triangles.map((t) => t.map((v) => v + first)));
  }
  return all;
}
const soup = ({ vertices, triangles }) => ({
  vertices: triangles.flatMap((t) => t.map((v) => vertices[v])),
  triangles: triangles.map((_, i) => [3 * i, 3 * i + 1, 3 * i + 2]),
});
const centre = ({ vertices, triangles }, i) => [0, 1, 2].map((k) => triangles[i].reduce((sum, v) => sum + vertices[v][k] / 3, 0));

const kBoxFaces = [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]];
const box = (low, high) => ({
  vertices: [...Array(8).keys()].map((c) => [0, 1, 2].map((k) => ((c >> k) & 1 ? high : low)[k])),
  triangles: kBoxFaces,
});

/** A closed strip of quads along an angle u, `across` points at each; joined with a twist where `twisted`. */
function strip(around, across, twisted, point) {
  const vertices = [], triangles = [];
  for (let i = 0; i < around; ++i) for (let j = 0; j < across; ++j) vertices.push(point((2 * Math.PI * i) / around, j / (across - 1)));
  const at = (i, j) => (i < around ? i * across + j : twisted ? across - 1 - j : j);
  for (let i = 0; i < around; ++i)
    for (let j = 0; j + 1 < across; ++j) triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
  return { vertices, triangles };
}

// --- files -----------------------------------------------------------------------------------------------------------

export function binaryStl({ vertices, triangles }, header = "defects", count = triangles.length) {
  const bytes = Buffer.alloc(84 + 50 * triangles.length);
  bytes.write(header, 0, 80, "latin1");
  bytes.writeUInt32LE(count, 80);
  triangles.forEach((t, i) => t.forEach((v, corner) => vertices[v].forEach((x, k) => bytes.writeFloatLE(x, 84 + 50 * i + 12 + 12 * corner + 4 * k))));
  return bytes;
}
function textStl({ vertices, triangles }) {
  const facet = (t) => `facet normal 0 0 1\nouter loop\n${t.map((v) => `vertex ${vertices[v].join(" ")}\n`).join("")}endloop\nendfacet\n`;
  return `solid defects\n${triangles.map(facet).join("")}endsolid defects\n`;
}
const obj = ({ vertices, triangles }) => vertices.map((p) => `v ${p.join(" ")}\n`).join("") + triangles.map((t) => `f ${t.map((v) => v + 1).join(" ")}\n`).join("");
const off = ({ vertices, triangles }) =>
  `OFF\n${vertices.length} ${triangles.length} 0\n` + vertices.map((p) => `${p.join(" ")}\n`).join("") + triangles.map((t) => `${t.length} ${t.join(" ")}\n`).join("");

// --- the defects -----------------------------------------------------------------------------------------------------

/**
 * Every file: { name, bytes, volume } with the volume in mm³ that must come out (within 1 %; absent where only the run
 * counts), or { name, bytes, refused } with what the sentence must say. `options` are more arguments of the run.
 * @returns {Generator<{name: string, bytes: Buffer|string, volume?: number, refused?: RegExp, options?: string[]}>}
 */
export function* defectiveFiles() {
  const bracket = model("bracket"), mushroom = model("mushroom"), teapot = model("teapot");
  const of = new Map([[bracket, volume(bracket)], [mushroom, volume(mushroom)], [teapot, volume(teapot)]]);
  const stl = (name, surface, whole) => ({ name: `${name}.stl`, bytes: binaryStl(surface), volume: of.get(whole) ?? whole });
  const cube = box([0, 0, 0], [20, 20, 20]);
  const r = random(7);
  const jitter = (size) => (p) => p.map((x) => x + size * (r() - 0.5));
  const near = (surface, at, radius) => (_, i) => Math.hypot(...centre(surface, i).map((x, k) => x - at[k])) < radius;
  const top = mushroom.vertices.reduce((best, p) => (p[2] > best[2] ? p : best));

  // Corners that should be one.
  yield stl("corners-apart", moved(soup(bracket), jitter(2e-5)), bracket);
  yield stl("corners-apart-teapot", moved(soup(teapot), jitter(2e-5)), teapot);
  yield { name: "unused-vertices.obj", bytes: obj({ ...bracket, vertices: [...bracket.vertices, [900, 900, 900], [-900, 0, 5]] }), volume: of.get(bracket) };
  yield stl("crack", moved(together(kept(mushroom, (_, i) => centre(mushroom, i)[0] < 0), kept(mushroom, (_, i) => centre(mushroom, i)[0] >= 0)),
    (p, i) => (i < mushroom.vertices.length ? p : [p[0] + 2e-3, p[1], p[2]])), mushroom);

  // Triangles without area, twice, or upside down.
  yield stl("flat-triangles", with_triangles(bracket, bracket.triangles.slice(0, 30).map(([a, b]) => [a, b, b])), bracket);
  yield stl("needle-triangles", (() => {
    const split = bracket.triangles.slice(0, 40), vertices = [...bracket.vertices], triangles = bracket.triangles.slice(40);
    for (const [a, b, c] of split) {
      const m = vertices.push(vertices[a].map((x, k) => x + 1e-4 * (vertices[b][k] - x) + 1e-4 * (vertices[c][k] - x))) - 1;
      triangles.push([a, b, m], [b, c, m], [c, a, m]);
    }
    return { vertices, triangles };
  })(), bracket);
  yield stl("doubled-triangles", with_triangles(bracket, bracket.triangles.filter((_, i) => i % 3 === 0)), bracket);
  yield stl("doubled-shell", with_triangles(mushroom, mushroom.triangles), mushroom);
  yield stl("both-sides", with_triangles(mushroom, flipped(mushroom).triangles));
  yield stl("one-flipped", flipped(bracket, (_, i) => i === 5), bracket);
  yield stl("half-flipped", flipped(bracket, (_, i) => i % 2 === 0), bracket);
  yield stl("all-flipped", flipped(teapot), teapot);
  yield stl("mirrored", moved(teapot, ([x, y, z]) => [-x, y, z]), teapot);

  // Holes.
  yield stl("one-triangle-missing", kept(mushroom, (_, i) => i !== 100), mushroom);
  yield stl("fifty-triangles-missing", kept(mushroom, (_, i) => i % Math.ceil(mushroom.triangles.length / 50) !== 3), mushroom);
  yield stl("curved-hole", kept(mushroom, (t, i) => !near(mushroom, top, 5)(t, i)), mushroom);
  yield stl("open-bottom", kept(bracket, (_, i) => centre(bracket, i)[2] > 1e-3), bracket);
  yield stl("open-box", { vertices: cube.vertices, triangles: cube.triangles.filter((t) => !t.every((v) => v >= 4)) }, 8000);
  yield stl("five-percent-missing", kept(teapot, () => r() > 0.05), teapot);
  yield stl("third-missing", kept(teapot, () => r() > 0.33));
  yield stl("half-a-model", kept(mushroom, (_, i) => centre(mushroom, i)[1] < 0.3));

  // Edges and vertices that are crowded or do not meet.
  yield stl("vertices-on-edges", (() => {
    const vertices = [...bracket.vertices];
    const triangles = bracket.triangles.flatMap((t, i) => {
      if (i % 5 !== 0) return [t];
      const m = vertices.push(vertices[t[0]].map((x, k) => (x + vertices[t[1]][k]) / 2)) - 1;
      return [[t[0], m, t[2]], [m, t[1], t[2]]];
    });
    return { vertices, triangles };
  })(), bracket);
  yield stl("fins", with_triangles({ ...mushroom, vertices: [...mushroom.vertices, [0, 40, 30], [40, 0, 30]] },
    [[...mushroom.triangles[10].slice(0, 2), mushroom.vertices.length], [...mushroom.triangles[900].slice(0, 2), mushroom.vertices.length + 1]]), mushroom);
  yield stl("wall-inside", with_triangles(cube, [[0, 1, 7], [0, 7, 6]]), 8000);
  yield stl("cubes-share-an-edge", together(cube, box([20, 20, 0], [40, 40, 20])), 16000);
  yield stl("cubes-share-a-corner", together(cube, box([20, 20, 20], [30, 30, 30]), box([20, 20, 0], [30, 30, 20])), 8000 + 1000 + 2000);
  yield stl("cubes-share-a-face", together(cube, box([20, 0, 0], [40, 20, 20])), 16000);
  yield stl("cube-on-part-of-a-face", together(cube, box([20, 5, 0], [40, 15, 10])), 10000);

  // Shells.
  yield stl("hollow", together(cube, flipped(box([6, 6, 6], [14, 14, 14]))), 8000 - 512);
  yield stl("nested-same-way", together(cube, box([6, 6, 6], [14, 14, 14])));
  yield stl("overlapping-boxes", together(cube, box([10, 10, 5], [30, 30, 15])), 8000 + 4000 - 1000);
  yield stl("overlapping-models", together(teapot, moved(teapot, ([x, y, z]) => [x + 9, y + 3, z])));
  yield stl("many-overlapping-boxes", together(...Array.from({ length: 60 }, () => {
    const [x, y, z] = [r(), r(), r()].map((s) => 30 * s);
    return box([x, y, z], [x + 10, y + 9, z + 8]);
  })));
  yield stl("cross-of-boxes", together(box([0, 15, 0], [40, 25, 10]), box([15, 0, 0], [25, 40, 10])), 4000 + 4000 - 1000);
  yield stl("overlapping-one-flipped", together(cube, flipped(box([10, 10, 5], [30, 30, 15]))));
  yield stl("debris", together(mushroom, ...Array.from({ length: 30 }, () => {
    const p = [r(), r(), r()].map((s) => 60 * s);
    return box(p, p.map((x) => x + 0.01));
  })), mushroom);
  yield stl("stray-triangle", together(mushroom, { vertices: [[60, 60, 0], [61, 60, 0], [60, 61, 0]], triangles: [[0, 1, 2]] }), mushroom);

  // Surfaces that cross themselves.
  yield stl("vertex-pushed-through", moved(mushroom, (p) => (p === top ? [p[0], p[1], p[2] - 30] : p)));
  yield stl("noise", moved(teapot, jitter(1.2)));
  yield stl("twisted-box", moved(cube, ([x, y, z]) => (z > 1 ? [20 - x, 20 - y, z] : [x, y, z])));
  yield { name: "figure-eight-tube.stl", bytes: binaryStl(strip(120, 24, false, (u, v) => {
    const w = 2 * Math.PI * v, R = 20 + 5 * Math.cos(w);
    return [R * Math.cos(u), R * Math.sin(2 * u), 5 * Math.sin(w) + 10];
  })), refused: /figure-eight-tube\.stl: .*no volume/ };

  // No inside.
  yield { name: "moebius-strip.stl", bytes: binaryStl(strip(90, 8, true, (u, v) => {
    const s = 12 * (v - 0.5);
    return [(25 + s * Math.cos(u / 2)) * Math.cos(u), (25 + s * Math.cos(u / 2)) * Math.sin(u), s * Math.sin(u / 2)];
  })), refused: /moebius-strip\.stl: .*open sheet/ };
  yield stl("klein-bottle", strip(80, 41, true, (u, v) => {
    const w = 2 * Math.PI * v, R = 20 + Math.cos(u / 2) * Math.sin(w) * 7 - Math.sin(u / 2) * Math.sin(2 * w) * 7;
    return [R * Math.cos(u), R * Math.sin(u), 7 * (Math.sin(u / 2) * Math.sin(w) + Math.cos(u / 2) * Math.sin(2 * w))];
  }));
  yield { ...stl("sheet", { vertices: [[0, 0, 0], [30, 0, 0], [30, 30, 0], [0, 30, 0]], triangles: [[0, 1, 2], [0, 2, 3]] }), refused: /sheet\.stl/ };
  yield { ...stl("sheet-made-thick", strip(40, 12, false, (u, v) => [20 * Math.cos(u), 20 * Math.sin(u), 15 * v])), options: ["--input.sheet_thickness", "2"] };
  yield stl("curved-sheet", kept(mushroom, (_, i) => centre(mushroom, i)[2] > 0.75 * top[2]));
  yield { ...stl("triangle-soup", { vertices: Array.from({ length: 900 }, () => [r(), r(), r()].map((s) => 40 * s)), triangles: Array.from({ length: 300 }, (_, i) => [3 * i, 3 * i + 1, 3 * i + 2]) }), refused: /triangle-soup\.stl: .*open sheet/ };

  // Numbers.
  yield stl("far-away", moved(bracket, ([x, y, z]) => [x + 4096, y - 8192, z + 2048]), bracket);
  yield stl("metres", moved(bracket, (p) => p.map((x) => x / 1000)), of.get(bracket) / 1e9);
  yield { name: "not-a-number.stl", bytes: binaryStl(moved(mushroom, (p, i) => (i === 50 ? [NaN, p[1], p[2]] : p))), refused: /not-a-number\.stl/ };
  yield { name: "infinite.obj", bytes: obj(mushroom).replace(/^v \S+/, "v inf"), refused: /infinite\.obj/ };
  yield { name: "huge-numbers.stl", bytes: binaryStl(moved(cube, (p) => p.map((x) => 1e30 * x))), refused: /huge-numbers\.stl/ };
  yield stl("one-vertex-far-out", moved(mushroom, (p, i) => (i === 200 ? [0, 0, 1e12] : p)), mushroom);

  // Files.
  yield { name: "text-wrong-normals.stl", bytes: textStl(bracket), volume: of.get(bracket) };
  yield { name: "binary-says-solid.stl", bytes: binaryStl(bracket, "solid by some program"), volume: of.get(bracket) };
  yield { name: "bytes-behind.stl", bytes: Buffer.concat([binaryStl(bracket), Buffer.from("made by some program")]), volume: of.get(bracket) };
  yield { name: "count-too-small.stl", bytes: binaryStl(bracket, "", 10), refused: /count-too-small\.stl/ };
  yield { name: "count-too-large.stl", bytes: binaryStl(bracket, "", 4e9), refused: /count-too-large\.stl/ };
  yield { name: "cut-short.stl", bytes: binaryStl(bracket).subarray(0, 3000), refused: /cut-short\.stl/ };
  yield { name: "text-cut-short.stl", bytes: textStl(bracket).slice(0, 5000), refused: /text-cut-short\.stl/ };
  yield { name: "text-as-stl.stl", bytes: "This is no model.\n", refused: /text-as-stl\.stl/ };
  yield { name: "empty.stl", bytes: "", refused: /empty\.stl/ };
  yield { name: "no-triangles.stl", bytes: binaryStl({ vertices: [], triangles: [] }), refused: /no-triangles\.stl/ };
  yield { name: "bent-quads.obj", bytes: obj({ vertices: cube.vertices.map((p, i) => (i === 7 ? [23, 22, 21] : p)), triangles: [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] }) };
  yield { name: "bow-tie-quad.off", bytes: off({ vertices: cube.vertices, triangles: [[0, 3, 2, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] }) };
  yield { name: "negative-indices.obj", bytes: obj(cube).replace(/^f (\d+) (\d+) (\d+)$/gm, (_, a, b, c) => `f ${a - 9} ${b - 9} ${c - 9}`), volume: 8000 };
  yield { name: "index-out-of-range.off", bytes: off(with_triangles(cube, [[0, 1, 99]])), refused: /index-out-of-range\.off/ };

  // Combined.
  const ragged = kept(flipped(moved(soup(mushroom), jitter(2e-5)), (_, i) => i % 7 === 0), (_, i) => i % 97 !== 0);
  yield stl("apart-flipped-holes", ragged, mushroom);
  yield stl("apart-flipped-holes-doubled", with_triangles(ragged, ragged.triangles.slice(0, 300)), mushroom);
  yield stl("holes-in-overlapping-shells", kept(together(teapot, moved(teapot, ([x, y, z]) => [x + 9, y + 3, z])), (_, i) => i % 101 !== 0));
  yield stl("fins-holes-debris", together(kept(with_triangles(bracket, [[0, 40, 90]]), (_, i) => i !== 33), box([50, 50, 0], [50.01, 50.01, 0.01])), bracket);
  yield stl("open-hollow-flipped", together(kept(cube, (_, i) => i !== 3), box([6, 6, 6], [14, 14, 14])));
  yield stl("noise-and-holes", kept(moved(teapot, jitter(0.8)), (_, i) => i % 61 !== 0));
  yield stl("everything", together(ragged, kept(moved(soup(bracket), (p) => jitter(2e-5)([p[0] + 30, p[1], p[2]])), (_, i) => i % 50 !== 1), cube));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const folder = process.argv[2];
  mkdirSync(folder, { recursive: true });
  for (const { name, bytes } of defectiveFiles()) writeFileSync(path.join(folder, name), bytes);
}
