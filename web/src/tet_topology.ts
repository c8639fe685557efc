// Which faces of a tet mesh are seen when some of its tets are taken away.
import type { TetArrays } from '../../wasm/index.js';

/** Corners of the face across from corner i, seen counter-clockwise from outside a tet of positive volume. */
const FACES = [1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1];

/**
 * The tet across each face: #T×4, −1 outside. Face i lies across from corner i.
 *
 * Linear time: faces are sorted by their least vertex with a counting sort, then met within short lists.
 */
export function tetNeighbors(tets: Uint32Array, vertexCount: number): Int32Array {
  const faceCount = tets.length;
  const begin = new Uint32Array(vertexCount + 1);
  const low = new Uint32Array(faceCount), middle = new Uint32Array(faceCount), high = new Uint32Array(faceCount);
  for (let face = 0; face < faceCount; ++face) {
    const base = face & ~3, at = 3 * (face & 3);
    const a = tets[base + FACES[at]!]!, b = tets[base + FACES[at + 1]!]!, c = tets[base + FACES[at + 2]!]!;
    low[face] = Math.min(a, b, c);
    high[face] = Math.max(a, b, c);
    middle[face] = a + b + c - low[face]! - high[face]!;
    begin[low[face]! + 1]!++;
  }
  for (let v = 0; v < vertexCount; ++v) begin[v + 1]! += begin[v]!;
  const order = new Uint32Array(faceCount), fill = begin.slice(0, vertexCount);
  for (let face = 0; face < faceCount; ++face) order[fill[low[face]!]!++] = face;
  const neighbors = new Int32Array(faceCount).fill(-1);
  for (let v = 0; v < vertexCount; ++v) {
    for (let i = begin[v]!; i < begin[v + 1]!; ++i) {
      const face = order[i]!;
      if (neighbors[face] !== -1) continue;
      for (let j = i + 1; j < begin[v + 1]!; ++j) {
        const other = order[j]!;
        if (middle[face] === middle[other] && high[face] === high[other]) {
          neighbors[face] = other >> 2;
          neighbors[other] = face >> 2;
          break;
        }
      }
    }
  }
  return neighbors;
}

export interface VisibleFaces {
  /** Three vertices a face. */
  vertices: Uint32Array;
  /** The tet of each face. */
  tets: Uint32Array;
  /** Faces that the cut opened begin here; those before are on the part's surface. */
  firstInner: number;
}

/** The outside of the tets that are kept. */
export function visibleFaces(mesh: Pick<TetArrays, 'tets'>, neighbors: Int32Array, kept: (tet: number) => boolean): VisibleFaces {
  const { tets } = mesh;
  const count = tets.length / 4;
  const keep = new Uint8Array(count);
  for (let t = 0; t < count; ++t) keep[t] = kept(t) ? 1 : 0;
  const outer: number[] = [], inner: number[] = [];
  for (let t = 0; t < count; ++t) {
    if (!keep[t]) continue;
    for (let i = 0; i < 4; ++i) {
      const other = neighbors[4 * t + i]!;
      if (other < 0) outer.push(4 * t + i);
      else if (!keep[other]) inner.push(4 * t + i);
    }
  }
  const faces = outer.concat(inner);
  const vertices = new Uint32Array(3 * faces.length), owner = new Uint32Array(faces.length);
  faces.forEach((face, at) => {
    const t = face >> 2;
    owner[at] = t;
    for (let k = 0; k < 3; ++k) vertices[3 * at + k] = tets[4 * t + FACES[3 * (face & 3) + k]!]!;
  });
  return { vertices, tets: owner, firstInner: outer.length };
}

/** Centroid of each tet along an axis. */
export function tetCentroids(mesh: Pick<TetArrays, 'tets' | 'positions'>, axis: 0 | 1 | 2): Float32Array {
  const { tets, positions } = mesh;
  const centroids = new Float32Array(tets.length / 4);
  for (let t = 0; t < centroids.length; ++t) {
    let sum = 0;
    for (let k = 0; k < 4; ++k) sum += positions[3 * tets[4 * t + k]! + axis]!;
    centroids[t] = sum / 4;
  }
  return centroids;
}
