// An evaluation of an output folder that shares no code with the slicer: it reads the files that a run wrote and
// computes the figures again from the definitions of report.json. Run it:  node tests/native/evaluator.mjs OUTDIR
import { readFileSync, readdirSync, existsSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => scale(a, 1 / (norm(a) || 1));
const sin = (deg) => Math.sin((deg * Math.PI) / 180);
const degrees = (rad) => (rad * 180) / Math.PI;
const clamp = (x, lo, hi) => Math.min(hi, Math.max(lo, x));

/** The arrays of a VTU file by name: {values, components}. */
export function readVtu(path) {
  const bytes = readFileSync(path);
  const appendedAt = bytes.indexOf('<AppendedData');
  const head = bytes.subarray(0, appendedAt < 0 ? bytes.length : appendedAt).toString('latin1');
  const header64 = /header_type="UInt64"/.test(head);
  const types = { Float64: Float64Array, Float32: Float32Array, Int64: BigInt64Array, Int32: Int32Array, UInt8: Uint8Array, Int8: Int8Array };
  let appended, raw = true;
  if (appendedAt >= 0) {
    const tag = bytes.subarray(appendedAt, appendedAt + 200).toString('latin1');
    raw = /encoding="raw"/.test(tag);
    appended = bytes.subarray(bytes.indexOf('_', appendedAt) + 1);
  }
  const unpack = (block, type) => {
    const headerSize = header64 ? 8 : 4;
    const size = header64 ? Number(block.readBigUInt64LE(0)) : block.readUInt32LE(0);
    const data = block.subarray(headerSize, headerSize + size);
    const copy = new Uint8Array(data).buffer;
    return new types[type](copy);
  };
  const arrays = {};
  const pattern = /<DataArray([^>]*?)(\/>|>([\s\S]*?)<\/DataArray>)/g;
  for (const match of head.matchAll(pattern)) {
    const attribute = (name) => (match[1].match(new RegExp(`${name}="([^"]*)"`)) ?? [])[1];
    const type = attribute('type'), format = attribute('format');
    let values;
    if (format === 'ascii') values = match[3].trim().split(/\s+/).map(Number);
    else if (format === 'appended') {
      const offset = Number(attribute('offset'));
      const block = raw ? appended.subarray(offset) : Buffer.from(appended.subarray(offset).toString('latin1').replace(/[^A-Za-z0-9+/=]/g, ''), 'base64');
      values = unpack(block, type);
    } else values = unpack(Buffer.from(match[3].trim(), 'base64'), type);
    if (values instanceof BigInt64Array) values = Int32Array.from(values, Number);
    arrays[attribute('Name') ?? 'Points'] = { values, components: Number(attribute('NumberOfComponents') ?? 1) };
  }
  return arrays;
}

const FACES = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

function readFields(path) {
  const arrays = readVtu(path);
  const points = arrays.Points ?? arrays.points;
  const row = (a, i) => [a.values[3 * i], a.values[3 * i + 1], a.values[3 * i + 2]];
  const vertexCount = points.values.length / 3, tetCount = arrays.connectivity.values.length / 4;
  const vertices = Array.from({ length: vertexCount }, (_, i) => row(points, i));
  const tets = Array.from({ length: tetCount }, (_, t) => Array.from(arrays.connectivity.values.subarray(4 * t, 4 * t + 4)));
  return { arrays, vertices, tets, row };
}

const det = (p, a, b, c, d) => dot(sub(p[b], p[a]), cross(sub(p[c], p[a]), sub(p[d], p[a])));

function gradient(vertices, tet, G) {
  const [a, b, c, d] = tet.map((v) => vertices[v]);
  const e1 = sub(b, a), e2 = sub(c, a), e3 = sub(d, a), volume6 = dot(e1, cross(e2, e3));
  let g = [0, 0, 0];
  g = add(g, scale(cross(e2, e3), (G[tet[1]] - G[tet[0]]) / volume6));
  g = add(g, scale(cross(e3, e1), (G[tet[2]] - G[tet[0]]) / volume6));
  return add(g, scale(cross(e1, e2), (G[tet[3]] - G[tet[0]]) / volume6));
}

function matchFaces(tets) {
  const open = new Map(), pairs = [];
  tets.forEach((tet, t) => FACES.forEach((face, f) => {
    const corners = face.map((i) => tet[i]).sort((x, y) => x - y);
    const key = corners.join();
    if (open.has(key)) { pairs.push([open.get(key)[0], t, face.map((i) => tet[i])]); open.delete(key); } else open.set(key, [t, f]);
  }));
  return { pairs, boundary: [...open.values()] };
}

/** SF, SQ, SR, concavity, foldovers and the gradient's range, from fields.vtu alone. */
export function evaluateField(path, planar = false) {
  const { arrays, vertices, tets, row } = readFields(path);
  const G = planar ? vertices.map((v) => v[2]) : arrays.G.values;
  const gradients = tets.map((tet) => gradient(vertices, tet, G));
  const lpd = gradients.map(unit);
  const { pairs, boundary } = matchFaces(tets);
  const zs = vertices.map((v) => v[2]);
  let low = Infinity, high = -Infinity;
  for (const z of zs) { low = Math.min(low, z); high = Math.max(high, z); }
  const limit = low + 0.01 * (high - low);
  const s = { area: 0, sf: 0, violation: 0, sq: 0, worst: 0 };
  for (const [t, f] of boundary) {
    const flip = det(vertices, ...tets[t]) < 0 ? -1 : 1;
    const [a, b, c] = FACES[f].map((i) => vertices[tets[t][i]]);
    const n2 = scale(cross(sub(b, a), sub(c, a)), flip), area = norm(n2) / 2, n = unit(n2);
    if (a[2] <= limit && b[2] <= limit && c[2] <= limit && n[2] < -0.9) continue;
    const d = lpd[t], nd = dot(n, d);
    s.area += area;
    const over = degrees(-Math.asin(clamp(nd, -1, 1))) - 45;
    if (over <= 1e-9) s.sf += area; else { s.violation += area * over; s.worst = Math.max(s.worst, over); }
    if (Math.abs(nd) <= sin(10) || Math.abs(nd) >= Math.cos(Math.PI / 18)) s.sq += area;
  }
  let concave20 = 0, gouging = 0, largest = 0;
  for (const [l, r, face] of pairs) {
    const cl = tets[l].reduce((m, v) => add(m, scale(vertices[v], 0.25)), [0, 0, 0]);
    const [a, b, c] = face.map((v) => vertices[v]);
    let m = cross(sub(b, a), sub(c, a));
    if (dot(m, sub(a, cl)) < 0) m = scale(m, -1);
    if (dot(sub(lpd[r], lpd[l]), m) >= 0) continue;
    const angle = degrees(Math.acos(clamp(dot(lpd[l], lpd[r]), -1, 1)));
    largest = Math.max(largest, angle);
    if (angle > 20) ++concave20;
    if (angle > 45) ++gouging;
  }
  const sizes = Float64Array.from(gradients, norm).sort();
  const deformed = arrays.deformed && Array.from({ length: vertices.length }, (_, i) => row(arrays.deformed, i));
  let foldovers = 0, down = 0;
  tets.forEach((tet, t) => {
    if (!planar && deformed && det(deformed, ...tet) * det(vertices, ...tet) <= 0) ++foldovers;
    if (gradients[t][2] <= 0) ++down;
  });
  let critical = null;
  if (arrays.critical && arrays.tau_max) {
    let n = 0, ok = 0;
    tets.forEach((_, t) => {
      if (!arrays.critical.values[t]) return;
      ++n;
      if (Math.abs(dot(lpd[t], unit(row(arrays.tau_max, t)))) <= sin(10)) ++ok;
    });
    critical = (100 * ok) / n;
  }
  return {
    tets: tets.length, support_free_area_percent: (100 * s.sf) / s.area, support_free_mean_violation_deg: s.violation / s.area,
    support_free_worst_deg: s.worst, surface_quality_area_percent: (100 * s.sq) / s.area, strength_critical_percent: critical,
    concave_pairs_over_20deg: concave20, gouging_pairs: gouging, largest_concave_deg: largest, foldovers, pointing_down: down,
    gradient_ratio: sizes[sizes.length - 1] / sizes[0], gradient_ratio_p99_p1: sizes[Math.floor(0.99 * sizes.length)] / sizes[Math.floor(0.01 * sizes.length)],
  };
}

/** {vertices, normals, thickness, triangles} of a binary little-endian or ASCII PLY. */
export function readPly(path) {
  const bytes = readFileSync(path);
  const end = bytes.indexOf('end_header') + 11;
  const lines = bytes.subarray(0, end).toString('latin1').split('\n');
  const size = { float: 4, float32: 4, double: 8, float64: 8, int: 4, int32: 4, uint: 4, uint32: 4, uchar: 1, uint8: 1, short: 2 };
  const read = {
    float: (o) => bytes.readFloatLE(o), double: (o) => bytes.readDoubleLE(o), int: (o) => bytes.readInt32LE(o), uint: (o) => bytes.readUInt32LE(o), uchar: (o) => bytes[o],
  };
  const canonical = (t) => ({ float32: 'float', float64: 'double', int32: 'int', uint32: 'uint', uint8: 'uchar' })[t] ?? t;
  let element = '', counts = {}, properties = [], list;
  for (const line of lines) {
    const w = line.trim().split(/\s+/);
    if (w[0] === 'element') { element = w[1]; counts[element] = Number(w[2]); }
    if (w[0] === 'property' && element === 'vertex') properties.push({ name: w[2], type: canonical(w[1]) });
    if (w[0] === 'property' && element === 'face') list = { count: canonical(w[2]), index: canonical(w[3]) };
  }
  let o = end;
  const columns = Object.fromEntries(properties.map((p) => [p.name, new Float64Array(counts.vertex)]));
  for (let v = 0; v < counts.vertex; ++v) for (const p of properties) { columns[p.name][v] = read[p.type](o); o += size[p.type]; }
  const triangles = [];
  for (let f = 0; f < counts.face; ++f) {
    const n = read[list.count](o);
    o += size[list.count];
    const corners = [];
    for (let i = 0; i < n; ++i) { corners.push(read[list.index](o)); o += size[list.index]; }
    triangles.push(corners);
  }
  const vertices = Array.from({ length: counts.vertex }, (_, v) => [columns.x[v], columns.y[v], columns.z[v]]);
  const normals = Array.from({ length: counts.vertex }, (_, v) => [columns.nx[v], columns.ny[v], columns.nz[v]]);
  return { vertices, normals, thickness: columns.thickness, triangles };
}

function pointTriangle(p, a, b, c) {
  const ab = sub(b, a), ac = sub(c, a), ap = sub(p, a);
  const d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return norm(ap);
  const bp = sub(p, b), d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return norm(bp);
  const vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return norm(sub(p, add(a, scale(ab, d1 / (d1 - d3)))));
  const cp = sub(p, c), d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return norm(cp);
  const vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return norm(sub(p, add(a, scale(ac, d2 / (d2 - d6)))));
  const va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return norm(sub(p, add(b, scale(sub(c, b), (d4 - d3) / (d4 - d3 + d5 - d6)))));
  return Math.abs(dot(ap, unit(cross(ab, ac))));
}

/** A hash grid over triangles or segments, for the nearest within one cell. */
class Grid {
  constructor(cell) { this.cell = cell; this.cells = new Map(); }
  key(i, j, k) { return ((i + 4096) * 8192 + (j + 4096)) * 8192 + (k + 4096); }
  insert(points, item) {
    const lo = [0, 1, 2].map((a) => Math.floor(Math.min(...points.map((p) => p[a])) / this.cell));
    const hi = [0, 1, 2].map((a) => Math.floor(Math.max(...points.map((p) => p[a])) / this.cell));
    for (let i = lo[0]; i <= hi[0]; ++i) for (let j = lo[1]; j <= hi[1]; ++j) for (let k = lo[2]; k <= hi[2]; ++k) {
      const key = this.key(i, j, k);
      const list = this.cells.get(key);
      if (list) list.push(item); else this.cells.set(key, [item]);
    }
  }
  *near(p) {
    const c = p.map((x) => Math.floor(x / this.cell));
    for (let i = -1; i <= 1; ++i) for (let j = -1; j <= 1; ++j) for (let k = -1; k <= 1; ++k) {
      const list = this.cells.get(this.key(c[0] + i, c[1] + j, c[2] + k));
      if (list) yield* list;
    }
  }
}

export function readLayers(outdir) {
  const folder = join(outdir, 'layers');
  return readdirSync(folder).filter((n) => n.endsWith('.ply')).sort().map((n) => readPly(join(folder, n)));
}

/** Distance of points of every layer to all earlier layers and the plate, against [min, max]. */
export function evaluateThickness(layers, min, max, every = 1) {
  const grid = new Grid(1.25 * max);
  let area = 0, outside = 0, unsupported = 0, declared = 0;
  const all = [];
  for (const layer of layers) {
    layer.triangles.forEach((tri, f) => {
      const [a, b, c] = tri.map((v) => layer.vertices[v]);
      const w = norm(cross(sub(b, a), sub(c, a))) / 2;
      if (f % every) return;
      for (const bary of [[1 / 3, 1 / 3, 1 / 3], [0.9, 0.05, 0.05], [0.05, 0.9, 0.05], [0.05, 0.05, 0.9]]) {
        const p = add(add(scale(a, bary[0]), scale(b, bary[1])), scale(c, bary[2]));
        let d = p[2];
        for (const t of grid.near(p)) d = Math.min(d, pointTriangle(p, ...t));
        area += w / 4;
        all.push([d, w]);
        if (d > 1.2 * max) unsupported += w / 4;
        if (d < min - 1e-6 || d > max + 1e-6) outside += w / 4;
        const t = tri.reduce((m, v, i) => m + layer.thickness[v] * bary[i], 0);
        declared = Math.max(declared, d < 1.2 * max ? Math.abs(t - d) : 0);
      }
    });
    for (const tri of layer.triangles) { const p = tri.map((v) => layer.vertices[v]); grid.insert(p, p); }
  }
  all.sort((x, y) => x[0] - y[0]);
  const total = all.reduce((m, x) => m + x[1], 0);
  const quantile = (q) => { let m = 0; for (const [d, w] of all) { m += w; if (m >= q * total) return d; } return all.at(-1)?.[0]; };
  return { area, min: all[0]?.[0], p1: quantile(0.01), p50: quantile(0.5), p99: quantile(0.99), max: all.at(-1)?.[0], outside_percent: (100 * outside) / area, unsupported_mm2: unsupported, largest_declared_difference: declared };
}

export function readWaypoints(path) {
  const lines = readFileSync(path, 'utf8').split('\n').filter((l) => l && !l.startsWith('#'));
  const names = lines[0].split(',');
  return lines.slice(1).map((line) => {
    const w = line.split(',');
    return Object.fromEntries(names.map((n, i) => [n, n === 'kind' ? w[i] : Number(w[i])]));
  });
}

/** Share of the layers' area within half a width of a path. */
export function evaluateCoverage(layers, waypoints) {
  const grid = new Grid(1.0);
  for (let i = 1; i < waypoints.length; ++i) {
    const a = waypoints[i - 1], b = waypoints[i];
    if (b.travel || a.path !== b.path || a.layer !== b.layer) continue;
    grid.insert([[a.x, a.y, a.z], [b.x, b.y, b.z]], { a: [a.x, a.y, a.z], b: [b.x, b.y, b.z], r: Math.max(a.width, b.width) / 2, n: [b.nx, b.ny, b.nz] });
  }
  let area = 0, covered = 0, beads = 0;
  for (const layer of layers) for (const tri of layer.triangles) {
    const [a, b, c] = tri.map((v) => layer.vertices[v]);
    const w = norm(cross(sub(b, a), sub(c, a))) / 2;
    const p = scale(add(add(a, b), c), 1 / 3);
    area += w;
    for (const s of grid.near(p)) {
      const e = sub(s.b, s.a), t = clamp(dot(sub(p, s.a), e) / (dot(e, e) || 1), 0, 1);
      const off = sub(p, add(s.a, scale(e, t)));
      if (Math.abs(dot(off, s.n)) < 0.15 && // the tip runs on the layer itself
        norm(off) <= s.r + 1e-6) { covered += w; break; }
    }
  }
  for (let i = 1; i < waypoints.length; ++i) {
    const a = waypoints[i - 1], b = waypoints[i];
    if (!b.travel && a.path === b.path) beads += Math.hypot(b.x - a.x, b.y - a.y, b.z - a.z) * 0.5 * (a.width + b.width);
  }
  return { area, coverage_percent: (100 * covered) / area, bead_area_over_layer_area: beads / area };
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const outdir = process.argv[2];
  const job = JSON.parse(readFileSync(join(outdir, 'job.json'), 'utf8'));
  const report = JSON.parse(readFileSync(join(outdir, 'report.json'), 'utf8'));
  const nozzle = job.nozzle?.diameter ?? 1;
  const min = job.layers?.min_thickness || 0.4 * nozzle, max = job.layers?.max_thickness || nozzle;
  console.log('curved', evaluateField(join(outdir, 'fields.vtu')));
  console.log('planar', evaluateField(join(outdir, 'fields.vtu'), true));
  const layers = readLayers(outdir);
  console.log('layers', layers.length, evaluateThickness(layers, min, max));
  if (existsSync(join(outdir, 'waypoints.csv'))) console.log(evaluateCoverage(layers, readWaypoints(join(outdir, 'waypoints.csv'))));
  console.log('report', report.curved);
}
