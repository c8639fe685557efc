// Makes the bundled models: node models/generate.mjs [NAME…]. Output is the same on every run.
//
// A model is an implicit solid max_i g_i(p) <= 0 of smooth functions g_i. Dual contouring meshes it: one vertex a grid
// cell that the surface crosses, one quad a crossed grid edge. Each vertex remembers which g_i it saw and is projected
// onto all of them, so walls are exact, edges between two g_i are sharp and the foot lies on z = 0. Between projections
// the vertices relax along the surface, which leaves triangles without slivers.
import { writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

// --- implicit shapes; p = [x, y, z] in mm ----------------------------------------------------------------------------

const hypot = Math.hypot;
/** Union with a fillet of about k mm. */
const blend = (a, b, k) => {
  const h = Math.max(k - Math.abs(a - b), 0) / k;
  return Math.min(a, b) - (h * h * h * k) / 6;
};
/** Intersection with a rounded edge of about k mm. */
const blendCut = (a, b, k) => -blend(-a, -b, k);
/** Box with half sizes `half`, rounded by r, in two or three dimensions. */
const roundedBox = (q, half, r) => {
  const d = q.map((x, i) => Math.abs(x) - half[i] + r);
  return hypot(...d.map((x) => Math.max(x, 0))) + Math.min(Math.max(...d), 0) - r;
};
const ellipsoid = (q, radii) => {
  const k0 = hypot(...q.map((x, i) => x / radii[i]));
  const k1 = hypot(...q.map((x, i) => x / (radii[i] * radii[i])));
  return k1 > 0 ? (k0 * (k0 - 1)) / k1 : -Math.min(...radii);
};
/** Cone with round ends: radius ra at a, rb at b. */
const roundCone = (p, a, b, ra, rb) => {
  const ab = b.map((x, i) => x - a[i]);
  const ap = p.map((x, i) => x - a[i]);
  const t = Math.min(1, Math.max(0, ap.reduce((s, x, i) => s + x * ab[i], 0) / ab.reduce((s, x) => s + x * x, 0)));
  return hypot(...ap.map((x, i) => x - t * ab[i])) - (ra + t * (rb - ra));
};
const torusY = ([x, y, z], [cx, cz], R, r) => hypot(hypot(x - cx, z - cz) - R, y) - r;
const plate = ([, , z]) => -z; // the solid stands on z = 0

/** `cell` is the grid's spacing and with it about the length of the triangles' edges, mm. */
const MODELS = {
  ring: {
    about: 'upright ring on a small foot',
    box: [[-40, -16, 0], [40, 16, 76]],
    cell: 1.3,
    parts: [(p) => blend(torusY(p, [0, 36], 30, 8), ellipsoid(p, [17, 15, 9]), 6), plate],
  },
  bridge: {
    about: 'arch between two feet',
    box: [[-56, -18, 0], [56, 18, 52]],
    cell: 1.3,
    parts: [
      (p) => {
        const arch = roundedBox([hypot(p[0], p[2]) - 40, p[1]], [6, 10], 3);
        const foot = roundedBox([Math.abs(p[0]) - 40, p[1], p[2]], [13, 15, 6], 3);
        return blend(arch, foot, 6);
      },
      plate,
    ],
  },
  dome: {
    about: 'base with walls and a free-form top, as an ankle support',
    box: [[-40, -30, 0], [40, 30, 42]],
    cell: 1.4,
    parts: [
      (p) => roundedBox([p[0], p[1]], [36, 26], 16),
      ([x, y, z]) => {
        // A ridge along x that sinks in the middle, with one shoulder higher than the other.
        const ridge = Math.exp(-(y * y) / 420);
        const top = 11 + ridge * (15 + 5 * Math.cos((x - 6) / 9) + 0.12 * x) + 2.5 * Math.sin(y / 11);
        return 0.6 * (z - top);
      },
      plate,
    ],
  },
  mushroom: {
    about: 'overhanging cap on a stem',
    box: [[-36, -36, 0], [36, 36, 66]],
    cell: 1.6,
    parts: [
      (p) => {
        const r = hypot(p[0], p[1]);
        const under = 36 + 0.004 * r * r - p[2];
        const cap = blendCut(ellipsoid([p[0], p[1], p[2] - 40], [32, 32, 22]), under, 6);
        const stem = blend(roundCone(p, [0, 0, -20], [0, 0, 45], 10, 8), ellipsoid(p, [18, 18, 7]), 8);
        return blend(cap, stem, 8);
      },
      plate,
    ],
  },
  teapot: {
    about: 'smooth body with a spout, a handle and a knob',
    box: [[-58, -34, 0], [58, 34, 64]],
    cell: 1.6,
    parts: [
      (p) => {
        const body = ellipsoid([p[0], p[1], p[2] - 22], [32, 32, 26]);
        const spout = blend(roundCone(p, [22, 0, 14], [40, 0, 26], 9, 6.5), roundCone(p, [40, 0, 26], [50, 0, 44], 6.5, 4.5), 5);
        const handle = hypot(hypot(p[0] + 34, (p[2] - 25) / 1.1) - 15, p[1]) - 4.6;
        const knob = ellipsoid([p[0], p[1], p[2] - 51], [6, 6, 7]);
        return blend(blend(blend(body, spout, 6), handle, 4), knob, 5);
      },
      plate,
    ],
  },
  bracket: {
    about: 'L-bracket with a rib and four holes',
    box: [[-4, -24, 0], [84, 24, 64]],
    cell: 1.5,
    parts: [
      (p) => {
        const base = roundedBox([p[0] - 40, p[1], p[2] + 2], [40, 21, 10], 2.5);
        const wall = roundedBox([p[0] - 4, p[1], p[2] - 25], [4, 21, 35], 2.5);
        const slope = (p[0] - 4) * 0.62 + (p[2] - 4) * 0.78 - 34;
        const rib = blendCut(blendCut(roundedBox([p[1]], [4], 0), slope, 7), Math.max(2 - p[0], 1 - p[2]), 2);
        return blend(blend(base, wall, 4), rib, 3);
      },
      (p) => 4.2 - hypot(p[0] - 62, p[1] - 11),
      (p) => 4.2 - hypot(p[0] - 62, p[1] + 11),
      (p) => 4.2 - hypot(p[1] - 12, p[2] - 46),
      (p) => 4.2 - hypot(p[1] + 12, p[2] - 46),
      plate,
    ],
  },
  trio: {
    about: 'three bodies on one plate',
    box: [[-42, -16, 0], [38, 16, 28]],
    cell: 1.4,
    parts: [
      (p) => {
        const arch = torusY(p, [-24, 0], 12, 4);
        const drop = blend(roundCone(p, [2, 0, -2], [2, 0, 18], 5, 8), ellipsoid([p[0] - 2, p[1], p[2]], [8, 8, 4]), 4);
        const block = roundedBox([p[0] - 27, p[1], p[2] - 6], [9, 14, 14], 4);
        return Math.min(arch, drop, block);
      },
      plate,
    ],
  },
};

// --- meshing ---------------------------------------------------------------------------------------------------------

const STEP = 1e-4; // mm, for gradients by central differences
const gradient = (g, p) =>
  [0, 1, 2].map((a) => {
    const forward = p.slice();
    const backward = p.slice();
    forward[a] += STEP;
    backward[a] -= STEP;
    return (g(forward) - g(backward)) / (2 * STEP);
  });

/** Moves p to the nearest point where all `parts` are zero: Gauss-Newton with the smallest step. */
function project(parts, p) {
  let q = p;
  for (let iteration = 0; iteration < 12; ++iteration) {
    const rows = parts.map((g) => ({ value: g(q), normal: gradient(g, q) }));
    if (rows.every(({ value }) => Math.abs(value) < 1e-9)) break;
    // One constraint after the other (Kaczmarz) converges to their common point and needs no matrix.
    const next = q.slice();
    for (let sweep = 0; sweep < (rows.length > 1 ? 20 : 1); ++sweep)
      for (const { value, normal } of rows) {
        const at = value + normal.reduce((s, n, i) => s + n * (next[i] - q[i]), 0);
        const square = normal.reduce((s, n) => s + n * n, 1e-12);
        for (let i = 0; i < 3; ++i) next[i] -= (at * normal[i]) / square;
      }
    q = next;
  }
  return q;
}

/** @returns {{vertices: number[][], triangles: number[][]}} closed, counter-clockwise from outside */
export function contour({ box, cell, parts }) {
  // Half a cell off z = 0, so that the plate passes through the middle of cells.
  const low = box[0].map((x, i) => x - (i === 2 ? 1.5 : 1.31) * cell);
  const size = box[1].map((x, i) => Math.ceil((x - low[i]) / cell) + 3);
  const id = (i, j, k) => (k * size[1] + j) * size[0] + i;
  const at = (i, j, k) => [low[0] + i * cell, low[1] + j * cell, low[2] + k * cell];
  const solid = (p) => Math.max(...parts.map((g) => g(p)));
  const value = new Float64Array(size[0] * size[1] * size[2]);
  for (let k = 0; k < size[2]; ++k)
    for (let j = 0; j < size[1]; ++j) for (let i = 0; i < size[0]; ++i) value[id(i, j, k)] = solid(at(i, j, k));

  const cells = new Map(); // cell → {sum of crossings, how many, parts seen}
  const quads = [];
  const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let k = 1; k < size[2] - 1; ++k)
    for (let j = 1; j < size[1] - 1; ++j)
      for (let i = 1; i < size[0] - 1; ++i)
        for (let a = 0; a < 3; ++a) {
          const [di, dj, dk] = axes[a];
          const inside = value[id(i, j, k)] < 0;
          if (inside === value[id(i + di, j + dj, k + dk)] < 0) continue;
          let t0 = 0;
          let t1 = 1;
          const p = at(i, j, k);
          const on = (t) => p.map((x, b) => x + axes[a][b] * t * cell);
          for (let n = 0; n < 30; ++n) {
            const middle = (t0 + t1) / 2;
            if (solid(on(middle)) < 0 === inside) t0 = middle;
            else t1 = middle;
          }
          const crossing = on(t0);
          const values = parts.map((g) => g(crossing));
          const part = values.indexOf(Math.max(...values));
          const b = axes[(a + 1) % 3];
          const c = axes[(a + 2) % 3];
          const around = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([u, v]) =>
            id(i - u * b[0] - v * c[0], j - u * b[1] - v * c[1], k - u * b[2] - v * c[2]));
          for (const key of around) {
            if (!cells.has(key)) cells.set(key, { index: cells.size, sum: [0, 0, 0], count: 0, parts: new Set() });
            const seen = cells.get(key);
            crossing.forEach((x, n) => (seen.sum[n] += x));
            ++seen.count;
            seen.parts.add(part);
          }
          const quad = around.map((key) => cells.get(key).index);
          quads.push(inside ? quad : quad.reverse());
        }

  const seen = [...cells.values()];
  const active = seen.map((s) => [...s.parts].sort((x, y) => x - y));
  let vertices = seen.map((s, v) => project(active[v].map((n) => parts[n]), s.sum.map((x) => x / s.count)));
  const neighbours = seen.map(() => new Set());
  for (const quad of quads)
    quad.forEach((v, n) => {
      neighbours[v].add(quad[(n + 1) % 4]);
      neighbours[quad[(n + 1) % 4]].add(v);
    });
  for (let pass = 0; pass < 12; ++pass)
    vertices = vertices.map((p, v) => {
      // Along an edge a vertex follows the edge's vertices only; corners stay.
      if (active[v].length > 2) return p;
      const along = [...neighbours[v]].filter((w) => active[v].every((part) => active[w].includes(part)));
      if (along.length < 2) return p;
      const mean = [0, 1, 2].map((i) => along.reduce((s, w) => s + vertices[w][i], 0) / along.length);
      return project(active[v].map((n) => parts[n]), p.map((x, i) => 0.5 * x + 0.5 * mean[i]));
    });

  const triangles = [];
  for (const [a, b, c, d] of quads) {
    const one = [[a, b, c], [a, c, d]];
    const other = [[a, b, d], [b, c, d]];
    const quality = (pair) => Math.min(...pair.map((t) => smallestAngle(vertices, t)));
    triangles.push(...(quality(one) >= quality(other) ? one : other));
  }
  return { vertices, triangles };
}

export function smallestAngle(vertices, triangle) {
  let smallest = Math.PI;
  for (let n = 0; n < 3; ++n) {
    const [p, q, r] = [0, 1, 2].map((m) => vertices[triangle[(n + m) % 3]]);
    const u = q.map((x, i) => x - p[i]);
    const v = r.map((x, i) => x - p[i]);
    const cosine = u.reduce((s, x, i) => s + x * v[i], 0) / (hypot(...u) * hypot(...v));
    smallest = Math.min(smallest, Math.acos(Math.min(1, Math.max(-1, cosine))));
  }
  return smallest;
}

/** Binary STL; equal vertices get equal bytes. */
export function binaryStl({ vertices, triangles }, header) {
  const bytes = Buffer.alloc(84 + 50 * triangles.length);
  bytes.write(header.slice(0, 79), 0, 'latin1');
  bytes.writeUInt32LE(triangles.length, 80);
  triangles.forEach((triangle, t) => {
    const [p, q, r] = triangle.map((v) => vertices[v]);
    const u = q.map((x, i) => x - p[i]);
    const v = r.map((x, i) => x - p[i]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = hypot(...normal) || 1;
    let offset = 84 + 50 * t;
    for (const x of [...normal.map((n) => n / length), ...p, ...q, ...r]) {
      bytes.writeFloatLE(Math.abs(x) < 1e-7 ? 0 : x, offset);
      offset += 4;
    }
  });
  return bytes;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const folder = dirname(fileURLToPath(import.meta.url));
  const names = process.argv.length > 2 ? process.argv.slice(2) : Object.keys(MODELS);
  for (const name of names) {
    const mesh = contour(MODELS[name]);
    writeFileSync(join(folder, `${name}.stl`), binaryStl(mesh, `S3 Slicer model ${name}: ${MODELS[name].about}`));
    const angles = mesh.triangles.map((t) => (smallestAngle(mesh.vertices, t) * 180) / Math.PI);
    console.log(`${name}: ${mesh.triangles.length} triangles, smallest angle ${Math.min(...angles).toFixed(1)}°, ` +
      `${angles.filter((a) => a < 15).length} triangles under 15°`);
  }
}
