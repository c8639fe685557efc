// The bundled models are what the README of models/ says: closed solids that stand flat on z = 0.
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import test from 'node:test';
import assert from 'node:assert/strict';
import { contour, smallestAngle } from '../models/generate.mjs';

const folder = join(dirname(fileURLToPath(import.meta.url)), '..', 'models');

/** Handles of each solid: how many holes go through it. */
const GENUS = { ring: 1, bridge: 0, dome: 0, mushroom: 0, teapot: 1, bracket: 4, trio: 0 };
/** Bodies of each model, where there are several. */
const BODIES = { trio: 3 };

/** Binary STL with equal corners made one vertex. */
function readStl(path) {
  const bytes = readFileSync(path);
  const count = bytes.readUInt32LE(80);
  assert.equal(bytes.length, 84 + 50 * count);
  const index = new Map();
  const vertices = [];
  const triangles = [];
  for (let t = 0; t < count; ++t) {
    const triangle = [];
    for (let corner = 0; corner < 3; ++corner) {
      const offset = 84 + 50 * t + 12 + 12 * corner;
      const p = [0, 4, 8].map((b) => bytes.readFloatLE(offset + b));
      const key = p.join(' ');
      if (!index.has(key)) {
        index.set(key, vertices.length);
        vertices.push(p);
      }
      triangle.push(index.get(key));
    }
    triangles.push(triangle);
  }
  return { vertices, triangles };
}

/** Fails unless every directed edge has exactly one opposite; returns V − E + F. */
function checkClosed({ vertices, triangles }) {
  const edges = new Set();
  for (const triangle of triangles)
    for (let n = 0; n < 3; ++n) {
      const edge = `${triangle[n]} ${triangle[(n + 1) % 3]}`;
      assert.ok(!edges.has(edge), `edge ${edge} occurs twice`);
      edges.add(edge);
    }
  for (const edge of edges) assert.ok(edges.has(edge.split(' ').reverse().join(' ')), `edge ${edge} is open`);
  return vertices.length - edges.size / 2 + triangles.length;
}

const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
const minus = (u, v) => u.map((x, i) => x - v[i]);

const volume = ({ vertices, triangles }) =>
  triangles.reduce((sum, t) => sum + dot(vertices[t[0]], cross(vertices[t[1]], vertices[t[2]])), 0) / 6;

for (const [name, genus] of Object.entries(GENUS)) {
  test(`${name} is a closed solid with ${genus} holes, standing flat on z = 0`, () => {
    const path = join(folder, `${name}.stl`);
    assert.ok(statSync(path).size < 1.5e6);
    const mesh = readStl(path);
    assert.equal(checkClosed(mesh), 2 * (BODIES[name] ?? 1) - 2 * genus);
    assert.ok(volume(mesh) > 0, 'triangles face outward');

    const z = mesh.vertices.map((p) => p[2]);
    assert.equal(z.reduce((a, b) => Math.min(a, b)), 0);
    for (let axis = 0; axis < 3; ++axis) {
      const x = mesh.vertices.map((p) => p[axis]);
      const extent = x.reduce((a, b) => Math.max(a, b)) - x.reduce((a, b) => Math.min(a, b));
      assert.ok(extent >= 25 && extent <= 120, `extent ${extent} mm along axis ${axis}`);
    }
    const foot = mesh.triangles.filter((t) => t.every((v) => mesh.vertices[v][2] === 0));
    const footArea = foot.reduce((sum, t) => {
      const [a, b, c] = t.map((v) => mesh.vertices[v]);
      return sum - cross(minus(b, a), minus(c, a))[2] / 2;
    }, 0);
    assert.ok(footArea > 150, `foot of ${footArea} mm²`);
    // Nothing else touches the plate.
    const onPlate = new Set(foot.flat());
    mesh.vertices.forEach((p, v) => assert.ok(p[2] > 0 || onPlate.has(v)));
    const angles = mesh.triangles.map((t) => (smallestAngle(mesh.vertices, t) * 180) / Math.PI);
    assert.ok(angles.every((angle) => angle > 10), `smallest angle ${angles.reduce((a, b) => Math.min(a, b))}°`);
  });
}

test('every bundled model is tested and listed with its licence', () => {
  const files = readdirSync(folder).filter((name) => /\.(stl|obj|off|tet)$/.test(name));
  assert.deepEqual(files.sort(), Object.keys(GENUS).map((name) => `${name}.stl`).sort());
  const readme = readFileSync(join(folder, 'README.md'), 'utf8');
  for (const file of files) assert.ok(readme.includes(file), `${file} is missing in models/README.md`);
});

test('contouring reproduces a half ball: closed, with its volume, sharp at the plate', () => {
  const radius = 10;
  const mesh = contour({
    box: [[-radius, -radius, 0], [radius, radius, radius]],
    cell: 0.9,
    parts: [(p) => Math.hypot(...p) - radius, (p) => -p[2]],
  });
  assert.equal(checkClosed(mesh), 2);
  const exact = (2 / 3) * Math.PI * radius ** 3;
  assert.ok(Math.abs(volume(mesh) / exact - 1) < 0.01, `volume ${volume(mesh)} of ${exact}`);
  const rim = mesh.vertices.filter((p) => Math.abs(p[2]) < 1e-6 && Math.abs(Math.hypot(...p) - radius) < 1e-6);
  assert.ok(rim.length > 60, `${rim.length} vertices on the rim`);
});
