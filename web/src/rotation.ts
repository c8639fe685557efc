// Rotations as `input.rotate` has them: degrees about the fixed axes x, then y, then z. Matrices are 3×3, row by row.

export type Vec = [number, number, number];
export type Matrix3 = [number, number, number, number, number, number, number, number, number];

const DEG = Math.PI / 180;

export function parseRotation(text: string): Vec | null {
  const parts = text.split(',').map((part) => Number(part.trim()));
  return parts.length === 3 && parts.every(Number.isFinite) ? (parts as Vec) : null;
}

export const formatRotation = (angles: Vec): string =>
  angles.map((angle) => String(Math.round(wrap(angle) * 1000) / 1000 + 0)).join(',');

const wrap = (angle: number): number => {
  const turned = ((((angle + 180) % 360) + 360) % 360) - 180;
  return turned === -180 ? 180 : turned;
};

export function multiply(a: Matrix3, b: Matrix3): Matrix3 {
  const product = [];
  for (let row = 0; row < 3; ++row) {
    for (let column = 0; column < 3; ++column) {
      let sum = 0;
      for (let k = 0; k < 3; ++k) sum += a[3 * row + k]! * b[3 * k + column]!;
      product.push(sum);
    }
  }
  return product as Matrix3;
}

/** Rz · Ry · Rx. */
export function matrixOf([x, y, z]: Vec): Matrix3 {
  const [cx, sx, cy, sy, cz, sz] = [x, y, z].flatMap((a) => [Math.cos(a * DEG), Math.sin(a * DEG)]) as
    [number, number, number, number, number, number];
  const rx: Matrix3 = [1, 0, 0, 0, cx, -sx, 0, sx, cx];
  const ry: Matrix3 = [cy, 0, sy, 0, 1, 0, -sy, 0, cy];
  const rz: Matrix3 = [cz, -sz, 0, sz, cz, 0, 0, 0, 1];
  return multiply(rz, multiply(ry, rx));
}

/** The inverse of matrixOf(). */
export function anglesOf(m: Matrix3): Vec {
  const y = Math.asin(Math.min(1, Math.max(-1, -m[6])));
  if (Math.abs(m[6]) > 1 - 1e-9) return [Math.atan2(-m[5], m[4]) / DEG, y / DEG, 0];
  return [Math.atan2(m[7], m[8]) / DEG, y / DEG, Math.atan2(m[3], m[0]) / DEG];
}

/** The smallest rotation that takes unit vector a to unit vector b. */
export function rotationBetween(a: Vec, b: Vec): Matrix3 {
  const cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  if (cosine < -1 + 1e-9) {
    // Half a turn about any axis across.
    const helper: Vec = Math.abs(a[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
    const axis = unit(cross(a, helper));
    return axisTimesAxis(axis, 2, -1);
  }
  const v = cross(a, b);
  const f = 1 / (1 + cosine);
  const [x, y, z] = v;
  return [
    1 - f * (y * y + z * z), f * x * y - z, f * x * z + y,
    f * x * y + z, 1 - f * (x * x + z * z), f * y * z - x,
    f * x * z - y, f * y * z + x, 1 - f * (x * x + y * y),
  ];
}

function axisTimesAxis(n: Vec, factor: number, diagonal: number): Matrix3 {
  const m: number[] = [];
  for (let i = 0; i < 3; ++i) for (let j = 0; j < 3; ++j) m.push(factor * n[i]! * n[j]! + (i === j ? diagonal : 0));
  return m as Matrix3;
}

export const cross = (a: Vec, b: Vec): Vec => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

export function unit(v: Vec): Vec {
  const length = Math.hypot(...v) || 1;
  return [v[0] / length, v[1] / length, v[2] / length];
}

/** The rotation after which the face with this outward normal, as it lies now, is on the plate. */
export function layOnPlate(rotation: Vec, normal: Vec): Vec {
  return anglesOf(multiply(rotationBetween(unit(normal), [0, 0, -1]), matrixOf(rotation)));
}

/** After a further turn about one of the plate's axes. */
export function turned(rotation: Vec, axis: 0 | 1 | 2, degrees: number): Vec {
  const turn: Vec = [0, 0, 0];
  turn[axis] = degrees;
  return anglesOf(multiply(matrixOf(turn), matrixOf(rotation)));
}

/**
 * From the file's frame to the rest frame as the stage `mesh` will have it, for showing the part before: up axis, scale,
 * rotation, lowest point on the plate; x and y are not shifted. 4×4, column by column.
 */
export function previewPlacement(positions: ArrayLike<number>, up: string, scale: number, rotation: Vec): Float64Array {
  const yUp: Matrix3 = [1, 0, 0, 0, 0, -1, 0, 1, 0];
  const turn = up === 'y' ? multiply(matrixOf(rotation), yUp) : matrixOf(rotation);
  const m = turn.map((value) => value * scale);
  let lowest = Infinity;
  for (let v = 0; v + 2 < positions.length; v += 3) {
    lowest = Math.min(lowest, m[6]! * positions[v]! + m[7]! * positions[v + 1]! + m[8]! * positions[v + 2]!);
  }
  const shift = Number.isFinite(lowest) ? -lowest : 0;
  return new Float64Array([m[0]!, m[3]!, m[6]!, 0, m[1]!, m[4]!, m[7]!, 0, m[2]!, m[5]!, m[8]!, 0, 0, 0, shift, 1]);
}

/** The angles that a placement turns by: of rotations that the slicer has found by itself. */
export function placementAngles(m: ArrayLike<number>, up: string): Vec {
  const scale = scaleOf(m);
  const turn = [0, 4, 8, 1, 5, 9, 2, 6, 10].map((at) => m[at]! / scale) as Matrix3;
  const zUp: Matrix3 = [1, 0, 0, 0, 0, 1, 0, -1, 0];
  return anglesOf(up === 'y' ? multiply(turn, zUp) : turn);
}

/** A point through a 4×4 matrix, column by column. */
export const transformPoint = (m: ArrayLike<number>, [x, y, z]: Vec): Vec => [
  m[0]! * x + m[4]! * y + m[8]! * z + m[12]!,
  m[1]! * x + m[5]! * y + m[9]! * z + m[13]!,
  m[2]! * x + m[6]! * y + m[10]! * z + m[14]!,
];

/** A point back through a 4×4 similarity (rotation, one factor, shift). */
export function untransformPoint(m: ArrayLike<number>, point: Vec): Vec {
  const d: Vec = [point[0] - m[12]!, point[1] - m[13]!, point[2] - m[14]!];
  const square = m[0]! ** 2 + m[1]! ** 2 + m[2]! ** 2;
  return [0, 4, 8].map((c) => (m[c]! * d[0] + m[c + 1]! * d[1] + m[c + 2]! * d[2]) / square) as Vec;
}

/** The factor of a 4×4 similarity. */
export const scaleOf = (m: ArrayLike<number>): number => Math.hypot(m[0]!, m[1]!, m[2]!);
