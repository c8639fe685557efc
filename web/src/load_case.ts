// Loads and painted regions as the editor keeps them, and as the core's files of them (core/fea/load_case.h).
import { scaleOf, transformPoint } from './rotation.ts';
import type { Vec } from './rotation.ts';

/** Faces of the part, in the file's frame. */
export type Patch =
  /** The face nearest to the point with all that hang together with it, turned by at most `angle` degrees. */
  | { kind: 'faces'; point: Vec; angle: number }
  /** A dab of the brush. */
  | { kind: 'sphere'; center: Vec; radius: number };

export type RegionKind = 'fixed' | 'force' | PaintKind;
export type PaintKind = 'surface' | 'critical';

export interface LoadRegion {
  id: number;
  name: string;
  /** What it is for: held, loaded, where surface quality counts, critical for strength. */
  kind: RegionKind;
  /** The contact with the plate counts as a part of the region. */
  plate: boolean;
  patches: Patch[];
  /** N in total, in the rest frame; forces only. */
  force: Vec;
  /** Fixed axes as "xyz"; fixed regions only. */
  axes: string;
  /** Load case from 1 on that it belongs to, 0 for all of them; fixed regions and forces only. */
  loadCase: number;
}

export interface Loads {
  material: string;
  regions: LoadRegion[];
}

export const NO_LOADS: Loads = { material: 'PLA', regions: [] };
export const MATERIALS = ['PLA', 'PETG', 'ABS', 'PA-CF'];

const isLoad = (region: LoadRegion): boolean => region.kind === 'fixed' || region.kind === 'force';
/** Whether anything is held or loaded, be it not yet complete. */
export const hasLoads = (loads: Loads): boolean => loads.regions.some(isLoad);

/** The numbers of the load cases, ascending; none where all regions belong to one case. */
export function caseNumbers(loads: Loads): number[] {
  return [...new Set(loads.regions.filter(isLoad).map((region) => region.loadCase))].filter((number) => number > 0).sort((a, b) => a - b);
}

/** As many as the core takes in one region. */
const MOST_PATCHES = 990;

/** What keeps the loads from being analysed, for people; empty when nothing does. */
export function loadProblems(loads: Loads): string[] {
  const problems: string[] = [];
  for (const region of loads.regions.filter(isLoad)) {
    if (!region.plate && region.patches.length === 0) problems.push(`“${region.name}” has no faces yet: pick or paint some.`);
    if (region.patches.length > MOST_PATCHES) problems.push(`“${region.name}” has too many dabs: paint it with a larger brush.`);
    if (region.kind === 'force' && Math.hypot(...region.force) === 0) problems.push(`“${region.name}” has a force of 0 N.`);
  }
  const numbers = caseNumbers(loads);
  for (const number of numbers.length > 0 ? numbers : [0]) {
    const inCase = number > 0 ? ` in case ${number}` : '';
    const members = loads.regions.filter((region) => region.loadCase === 0 || region.loadCase === number);
    if (!members.some((region) => region.kind === 'fixed')) problems.push(`Nothing holds the part${inCase}: add a fixed region.`);
    if (!members.some((region) => region.kind === 'force')) problems.push(`Nothing loads the part${inCase}: add a force.`);
  }
  return problems;
}

/** What is wrong with the painted regions of a kind, for people; empty when nothing is. */
export function paintProblems(loads: Loads, kind: PaintKind): string[] {
  const painted = loads.regions.filter((region) => region.kind === kind);
  const patches = painted.reduce((sum, region) => sum + region.patches.length, 0);
  const names = painted.map((region) => `“${region.name}”`).join(', ');
  if (patches > MOST_PATCHES) return [`${names}: too many dabs, left out. Paint with a larger brush.`];
  return painted.filter((region) => region.patches.length === 0 && !region.plate).map((region) => `“${region.name}” has no faces yet, it is left out: pick or paint some.`);
}

const rounded = (v: Vec): Vec => v.map((x) => Math.round(x * 1e6) / 1e6 + 0) as Vec;

/** The core's shapes of a region in the rest frame. */
function shapesOf(region: LoadRegion, placement: ArrayLike<number>): unknown[] {
  const shapes: unknown[] = region.plate ? ['plate'] : [];
  for (const patch of region.patches) {
    shapes.push(
      patch.kind === 'faces'
        ? { faces: { points: [rounded(transformPoint(placement, patch.point))], angle: patch.angle } }
        : { sphere: { center: rounded(transformPoint(placement, patch.center)), radius: patch.radius * scaleOf(placement) } },
    );
  }
  return shapes;
}

/**
 * The core's load case.
 * @param placement  4×4, column by column: from the file's frame to the rest frame, where load cases live
 */
export function loadCaseJson(loads: Loads, placement: ArrayLike<number>): string {
  const regions: Record<string, unknown> = {};
  const conditionsOf = (number: number): unknown[] | undefined => {
    const members = loads.regions.filter((region) => isLoad(region) && region.loadCase === number);
    if (members.length === 0) return undefined;
    return members.map((region) => {
      const name = `${region.id} ${region.name}`;
      regions[name] = shapesOf(region, placement);
      return region.kind === 'fixed' ? { region: name, fixed: region.axes === 'xyz' ? true : region.axes } : { region: name, force: region.force };
    });
  };
  const conditions = conditionsOf(0);
  const numbers = caseNumbers(loads);
  const cases = numbers.length > 0 ? numbers.map((number) => ({ name: `Case ${number}`, conditions: conditionsOf(number) })) : undefined;
  return JSON.stringify({ material: loads.material, regions, conditions, cases }, null, 1);
}

/** The core's region file of all that is painted for one purpose; empty where nothing is. */
export function regionJson(loads: Loads, kind: PaintKind, placement: ArrayLike<number>): string {
  const region = loads.regions.filter((one) => one.kind === kind).flatMap((one) => shapesOf(one, placement));
  return region.length === 0 || region.length > MOST_PATCHES ? '' : JSON.stringify({ region }, null, 1);
}

/** Loads that survived JSON; null when it is something else. */
export function loadsFrom(value: unknown): Loads | null {
  if (typeof value !== 'object' || value === null) return null;
  const { material, regions } = value as Partial<Loads>;
  if (typeof material !== 'string' || !Array.isArray(regions)) return null;
  if (!regions.every((region) => typeof region?.name === 'string' && Array.isArray(region.patches) && Array.isArray(region.force))) return null;
  // Projects of before there were several cases say nothing of them.
  return { material, regions: regions.map((region) => ({ ...region, loadCase: region.loadCase ?? 0 })) };
}

/**
 * Neighbours of the triangles of an indexed surface: #F×3, across the edges 01, 12, 20; −1 where there is none.
 */
export function triangleNeighbors(indices: Uint32Array, vertexCount: number): Int32Array {
  const neighbors = new Int32Array(indices.length).fill(-1);
  const open = new Map<number, number>();
  for (let corner = 0; corner < indices.length; ++corner) {
    const next = corner % 3 === 2 ? corner - 2 : corner + 1;
    const a = indices[corner]!, b = indices[next]!;
    const key = Math.min(a, b) * vertexCount + Math.max(a, b);
    const other = open.get(key);
    if (other === undefined) {
      open.set(key, corner);
    } else {
      neighbors[corner] = Math.floor(other / 3);
      neighbors[other] = Math.floor(corner / 3);
      open.delete(key);
    }
  }
  return neighbors;
}

export interface SurfaceShape {
  positions: ArrayLike<number>;
  indices: Uint32Array;
  neighbors: Int32Array;
}

function faceNormal({ positions, indices }: SurfaceShape, face: number): Vec {
  const [a, b, c] = [0, 1, 2].map((k) => 3 * indices[3 * face + k]!) as Vec;
  const u = [0, 1, 2].map((k) => positions[b + k]! - positions[a + k]!) as Vec;
  const v = [0, 1, 2].map((k) => positions[c + k]! - positions[a + k]!) as Vec;
  const n: Vec = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...n) || 1;
  return [n[0] / length, n[1] / length, n[2] / length];
}

function centroid({ positions, indices }: SurfaceShape, face: number): Vec {
  return [0, 1, 2].map(
    (k) => (positions[3 * indices[3 * face]! + k]! + positions[3 * indices[3 * face + 1]! + k]! + positions[3 * indices[3 * face + 2]! + k]!) / 3,
  ) as Vec;
}

/** Faces that hang together with a face and are turned against it by at most `angle` degrees, itself included. */
export function floodFaces(surface: SurfaceShape, seed: number, angle: number): number[] {
  const limit = Math.cos((angle * Math.PI) / 180) - 1e-6;
  const normal = faceNormal(surface, seed);
  const seen = new Set([seed]);
  const queue = [seed];
  for (let at = 0; at < queue.length; ++at) {
    for (let edge = 0; edge < 3; ++edge) {
      const next = surface.neighbors[3 * queue[at]! + edge]!;
      if (next < 0 || seen.has(next)) continue;
      seen.add(next);
      const n = faceNormal(surface, next);
      if (n[0] * normal[0] + n[1] * normal[1] + n[2] * normal[2] >= limit) queue.push(next);
    }
  }
  return queue;
}

/** Faces of a patch on a surface in the frame of the patch: what the views highlight. */
export function facesOf(surface: SurfaceShape, patch: Patch): number[] {
  if (patch.kind === 'faces') return floodFaces(surface, nearestFace(surface, patch.point), patch.angle);
  const faces: number[] = [];
  for (let face = 0; face < surface.indices.length / 3; ++face) {
    const c = centroid(surface, face);
    if (Math.hypot(c[0] - patch.center[0], c[1] - patch.center[1], c[2] - patch.center[2]) <= patch.radius) faces.push(face);
  }
  return faces;
}

function nearestFace(surface: SurfaceShape, point: Vec): number {
  let best = 0, least = Infinity;
  for (let face = 0; face < surface.indices.length / 3; ++face) {
    const distance = squaredDistanceToFace(surface, face, point);
    if (distance < least) [best, least] = [face, distance];
  }
  return best;
}

/** Squared distance to a triangle, by the region of the plane that the point projects to. */
function squaredDistanceToFace({ positions, indices }: SurfaceShape, face: number, p: Vec): number {
  const at = (k: number): Vec => {
    const v = 3 * indices[3 * face + k]!;
    return [positions[v]!, positions[v + 1]!, positions[v + 2]!];
  };
  const sub = (u: Vec, v: Vec): Vec => [u[0] - v[0], u[1] - v[1], u[2] - v[2]];
  const dot = (u: Vec, v: Vec): number => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  const corners = [at(0), at(1), at(2)] as const;
  const ab = sub(corners[1], corners[0]), ac = sub(corners[2], corners[0]), ap = sub(p, corners[0]);
  const d00 = dot(ab, ab), d01 = dot(ab, ac), d11 = dot(ac, ac), d20 = dot(ap, ab), d21 = dot(ap, ac);
  const area = d00 * d11 - d01 * d01;
  if (area > 0) {
    const v = (d11 * d20 - d01 * d21) / area, w = (d00 * d21 - d01 * d20) / area;
    if (v >= 0 && w >= 0 && v + w <= 1) {
      const q: Vec = [ap[0] - v * ab[0] - w * ac[0], ap[1] - v * ab[1] - w * ac[1], ap[2] - v * ab[2] - w * ac[2]];
      return dot(q, q);
    }
  }
  let least = Infinity;
  for (let k = 0; k < 3; ++k) {
    const edge = sub(corners[(k + 1) % 3]!, corners[k]!), to = sub(p, corners[k]!);
    const t = Math.min(1, Math.max(0, dot(to, edge) / (dot(edge, edge) || 1)));
    const q: Vec = [to[0] - t * edge[0], to[1] - t * edge[1], to[2] - t * edge[2]];
    least = Math.min(least, dot(q, q));
  }
  return least;
}
