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
const norm = (a) => Math.sqrt(dot(a, a));
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
    if (over <= 1e-6) s.sf += area; else { s.violation += area * over; s.worst = Math.max(s.worst, over); }
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

/** {layer, vertices, normals, thickness, triangles} of a binary little-endian PLY. */
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
  const layer = Number(/^comment layer (\d+)/m.exec(lines.join('\n'))[1]);
  return { layer, vertices, normals, thickness: columns.thickness, triangles };
}

/** Squared distance of the point x y z from triangle t of an array of nine numbers each: a, b − a, c − a. */
function pointTriangle2(x, y, z, T, t) {
  const o = 9 * t;
  const px = x - T[o], py = y - T[o + 1], pz = z - T[o + 2];
  const ux = T[o + 3], uy = T[o + 4], uz = T[o + 5], vx = T[o + 6], vy = T[o + 7], vz = T[o + 8];
  const uu = ux * ux + uy * uy + uz * uz, uv = ux * vx + uy * vy + uz * vz, vv = vx * vx + vy * vy + vz * vz;
  const pu = px * ux + py * uy + pz * uz, pv = px * vx + py * vy + pz * vz, pp = px * px + py * py + pz * pz;
  const D = uu * vv - uv * uv, s = (vv * pu - uv * pv) / D, r = (uu * pv - uv * pu) / D;
  // |p − s u − r v|² as a quadratic form: inside, or the least of the three edges.
  const at = (i, j) => pp - 2 * (i * pu + j * pv) + i * i * uu + 2 * i * j * uv + j * j * vv;
  if (s >= 0 && r >= 0 && s + r <= 1) return Math.max(0, at(s, r));
  const on = (n, d) => (d > 0 ? clamp(n / d, 0, 1) : 0);
  const k = on(pv - pu + uu - uv, uu - 2 * uv + vv);
  return Math.max(0, Math.min(at(on(pu, uu), 0), at(0, on(pv, vv)), at(1 - k, k)));
}

/** A hash grid over boxes, for what is nearer than one cell. */
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
  /** The lists of items around p; an item may be in several. */
  near(p) {
    const x = Math.floor(p[0] / this.cell), y = Math.floor(p[1] / this.cell), z = Math.floor(p[2] / this.cell);
    const lists = [];
    for (let i = -1; i <= 1; ++i) for (let j = -1; j <= 1; ++j) for (let k = -1; k <= 1; ++k) {
      const list = this.cells.get(this.key(x + i, y + j, z + k));
      if (list) lists.push(list);
    }
    return lists;
  }
}

/** The layer pieces of an output folder in print order. */
export function readLayers(outdir) {
  const folder = join(outdir, 'layers');
  return readdirSync(folder).filter((n) => n.endsWith('.ply')).sort().map((n) => readPly(join(folder, n)));
}

const triangleArea = (a, b, c) => norm(cross(sub(b, a), sub(c, a))) / 2;
const mix = (a, b, c, [u, v, w]) => [0, 1, 2].map((i) => u * a[i] + v * b[i] + w * c[i]);

/**
 * Distance of every layer to the plate and to what was printed before it, of other isosurfaces, against [min, max].
 * Four points a triangle: its middle, and one near each corner.
 */
export function evaluateThickness(layers, min, max) {
  const reach = 1.25 * max, grid = new Grid(reach);
  const count = layers.reduce((n, layer) => n + layer.triangles.length, 0);
  const T = new Float64Array(9 * count), middle = new Float64Array(4 * count), layerOf = new Int32Array(count);
  const nearest = (p, layer) => {
    let best = Math.min(p[2], reach);
    for (const list of grid.near(p)) for (const t of list) {
      if (layerOf[t] === layer) continue;
      const x = p[0] - middle[4 * t], y = p[1] - middle[4 * t + 1], z = p[2] - middle[4 * t + 2], r = best + middle[4 * t + 3];
      if (x * x + y * y + z * z >= r * r) continue;
      best = Math.min(best, Math.sqrt(pointTriangle2(p[0], p[1], p[2], T, t)));
    }
    return best;
  };
  let area = 0, thin = 0, thick = 0, declared = 0, next = 0;
  const all = [], places = [];
  for (const layer of layers) {
    for (const tri of layer.triangles) {
      const [a, b, c] = tri.map((v) => layer.vertices[v]);
      const w = triangleArea(a, b, c) / 4;
      for (const weights of [[1 / 3, 1 / 3, 1 / 3], [0.9, 0.05, 0.05], [0.05, 0.9, 0.05], [0.05, 0.05, 0.9]]) {
        const p = mix(a, b, c, weights), d = nearest(p, layer.layer);
        area += w;
        all.push([d, w]);
        if (d < min - 1e-6) thin += w;
        if (d > max + 1e-6) thick += w;
        if (d < min - 1e-6 || d > max + 1e-6) places.push({ d, at: p, layer: layer.layer });
        const said = tri.reduce((m, v, i) => m + layer.thickness[v] * weights[i], 0);
        if (d < max) declared = Math.max(declared, Math.abs(said - d));
      }
    }
    for (const tri of layer.triangles) {
      const [a, b, c] = tri.map((v) => layer.vertices[v]);
      const m = scale(add(add(a, b), c), 1 / 3), t = next++;
      T.set([...a, ...sub(b, a), ...sub(c, a)], 9 * t);
      middle.set([...m, Math.max(norm(sub(a, m)), norm(sub(b, m)), norm(sub(c, m))) + 1e-9], 4 * t);
      layerOf[t] = layer.layer;
      grid.insert([a, b, c], t);
    }
  }
  all.sort((x, y) => x[0] - y[0]);
  const quantile = (q) => { let m = 0; for (const [d, w] of all) { m += w; if (m >= q * area) return d; } return all.at(-1)?.[0]; };
  return {
    area, min: all[0]?.[0], p1: quantile(0.01), p50: quantile(0.5), p99: quantile(0.99), max: all.at(-1)?.[0],
    outside_percent: (100 * (thin + thick)) / area, thin_percent: (100 * thin) / area, thick_percent: (100 * thick) / area,
    largest_declared_difference: declared, worst: places.sort((x, y) => Math.max(min - y.d, y.d - max) - Math.max(min - x.d, x.d - max)).slice(0, 5),
  };
}

export function readWaypoints(path) {
  const lines = readFileSync(path, 'utf8').split('\n').filter((l) => l && !l.startsWith('#'));
  const names = lines[0].split(',');
  return lines.slice(1).map((line) => {
    const w = line.split(',');
    return Object.fromEntries(names.map((n, i) => [n, n === 'kind' ? w[i] : Number(w[i])]));
  });
}

/** The extruded stretches between waypoints, by isosurface; their places along the path, and which paths are closed. */
function beadsByLayer(waypoints) {
  const beads = new Map(), length = new Map();
  let along = 0, first = 0; // the waypoint at which the path begins, after its travel
  for (let i = 1; i < waypoints.length; ++i) {
    const p = waypoints[i - 1], q = waypoints[i];
    if (q.travel || q.path !== p.path) { along = 0; first = i; continue; }
    const a = [p.x, p.y, p.z], b = [q.x, q.y, q.z], size = norm(sub(b, a));
    if (!beads.has(q.layer)) beads.set(q.layer, []);
    beads.get(q.layer).push({ a, e: sub(b, a), size, wa: p.width, wb: q.width, from: along, path: q.path });
    along += size;
    const start = waypoints[first];
    length.set(q.path, Math.hypot(q.x - start.x, q.y - start.y, q.z - start.z) < 1e-4 ? along : Infinity);
  }
  return { beads, length };
}

/** How many separate stretches of path touch a point: [{path, at}], at in mm along the path. */
function countStrands(touching, length, gap) {
  touching.sort((p, q) => p.path - q.path || p.at - q.at);
  let strands = 0;
  for (let i = 0; i < touching.length;) {
    let j = i + 1, own = 1;
    for (; j < touching.length && touching[j].path === touching[i].path; ++j) if (touching[j].at - touching[j - 1].at > gap) ++own;
    if (own > 1 && touching[i].at + length.get(touching[i].path) - touching[j - 1].at <= gap) --own;
    strands += own;
    i = j;
  }
  return strands;
}

/** About `count` points spread evenly over the pieces of layers: [{p, piece}], all of the same area. */
function spreadPoints(layers, count) {
  const total = layers.reduce((m, l) => l.triangles.reduce((n, t) => n + triangleArea(...t.map((v) => l.vertices[v])), m), 0);
  const step = total / count, points = [];
  let reached = 0, next = 0.5 * step, k = 0;
  layers.forEach((layer, piece) => {
    for (const tri of layer.triangles) {
      const [a, b, c] = tri.map((v) => layer.vertices[v]);
      for (reached += triangleArea(a, b, c); next < reached; next += step) {
        // A low-discrepancy sequence in the unit square, folded into the triangle.
        let u = (++k * 0.7548776662466927) % 1, v = (k * 0.5698402909980532) % 1;
        if (u + v > 1) { u = 1 - u; v = 1 - v; }
        points.push({ p: mix(a, b, c, [1 - u - v, u, v]), piece });
      }
    }
  });
  return { points, step };
}

/** Distance of p from the segment a to a + e, and where along it, 0 to 1, the nearest point is. */
function fromSegment(p, a, e) {
  const x = p[0] - a[0], y = p[1] - a[1], z = p[2] - a[2];
  const t = clamp((x * e[0] + y * e[1] + z * e[2]) / (dot(e, e) || 1), 0, 1);
  const u = x - t * e[0], v = y - t * e[1], w = z - t * e[2];
  return { off: Math.sqrt(u * u + v * v + w * w), t };
}

/** Distance from the rim of one piece, known up to `reach`. */
function rimDistance(layer, reach) {
  const seen = new Map();
  for (const tri of layer.triangles) tri.forEach((v, i) => {
    const w = tri[(i + 1) % 3], key = v < w ? v * layer.vertices.length + w : w * layer.vertices.length + v;
    seen.set(key, seen.has(key) ? null : [v, w]);
  });
  const grid = new Grid(reach);
  for (const edge of seen.values()) if (edge) { const [a, b] = edge.map((v) => layer.vertices[v]); grid.insert([a, b], { a, e: sub(b, a) }); }
  return (p) => {
    let best = reach;
    for (const list of grid.near(p)) for (const { a, e } of list) best = Math.min(best, fromSegment(p, a, e).off);
    return best;
  };
}

/**
 * Share of the layers' area within half a bead of a path, and, where the layer is wider than two beads (in a disc of
 * the bead's width as radius that stays inside the rim), the share laid more than once; laid three times counts twice.
 */
export function evaluateCoverage(layers, waypoints, width, count = 100000) {
  const { beads, length } = beadsByLayer(waypoints);
  const widest = waypoints.reduce((m, w) => Math.max(m, w.width), width), sliver = 0.002 * width;
  const { points, step } = spreadPoints(layers, count);
  let covered = 0, wide = 0, overlap = 0, at = 0, grid, gridLayer;
  for (let piece = 0; piece < layers.length; ++piece) {
    const layer = layers[piece], begin = at;
    while (at < points.length && points[at].piece === piece) ++at;
    const own = points.slice(begin, at);
    if (own.length === 0) continue;
    if (gridLayer !== layer.layer) {
      gridLayer = layer.layer;
      grid = new Grid(widest / 2 + sliver);
      for (const s of beads.get(gridLayer) ?? []) grid.insert([s.a, add(s.a, s.e)], s);
    }
    const reach = 1.5 * width, rim = rimDistance(layer, reach), discs = new Grid(reach);
    for (const q of layer.vertices) { const d = rim(q); if (d >= width) discs.insert([q], { q, d }); }
    for (const { p } of own) {
      const touching = [];
      let hit = false;
      for (const s of new Set(grid.near(p).flat())) {
        const { off, t } = fromSegment(p, s.a, s.e), half = 0.5 * ((1 - t) * s.wa + t * s.wb);
        if (off <= half + sliver) hit = true;
        if (off <= half - sliver) touching.push({ path: s.path, at: s.from + t * s.size });
      }
      if (hit) ++covered;
      if (rim(p) < width && !discs.near(p).some((list) => list.some(({ q, d }) => norm(sub(p, q)) <= d))) continue;
      ++wide;
      if (touching.length > 1) overlap += Math.max(0, countStrands(touching, length, 1.5 * width) - 1);
    }
  }
  const path = [...beads.values()].flat().reduce((m, s) => m + s.size, 0);
  return {
    area: step * points.length, coverage_percent: (100 * covered) / points.length, wide_percent: (100 * wide) / points.length,
    overlap_percent: (100 * overlap) / wide, path_length_mm: path,
  };
}

/** Everything about a finished run: {job, report, field, thickness, coverage}. */
export function evaluate(outdir) {
  const [job, report] = ['job.json', 'report.json'].map((name) => JSON.parse(readFileSync(join(outdir, name), 'utf8')));
  const nozzle = job.nozzle.diameter;
  const min = job.layers.min_thickness || 0.4 * nozzle, max = job.layers.max_thickness || nozzle;
  const layers = readLayers(outdir);
  return {
    job, report,
    field: evaluateField(join(outdir, 'fields.vtu')),
    thickness: evaluateThickness(layers, min, max),
    coverage: evaluateCoverage(layers, readWaypoints(join(outdir, 'waypoints.csv')), job.toolpath.width || nozzle),
  };
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  const outdir = process.argv[2];
  if (existsSync(join(outdir, 'waypoints.csv'))) {
    const { report, field, thickness, coverage } = evaluate(outdir);
    console.log('curved', field, '\nthickness', thickness, '\ncoverage', coverage, '\nreport', report.curved);
  } else console.log('curved', evaluateField(join(outdir, 'fields.vtu')));
  console.log('planar', evaluateField(join(outdir, 'fields.vtu'), true));
}
