// The preference triangle: a point in it stands for the shares of the three objectives.

export type Weights = [supportFree: number, strength: number, surfaceQuality: number];
export interface Point2 {
  x: number;
  y: number;
}

/** Corners in a box of 1 × √3/2, y down: support free on top, strength left, surface quality right. */
export const CORNERS: [Point2, Point2, Point2] = [
  { x: 0.5, y: 0 },
  { x: 0, y: Math.sqrt(3) / 2 },
  { x: 1, y: Math.sqrt(3) / 2 },
];

/** The shares at a point, clamped to the triangle, in steps of 5 %; they add up to 1. */
export function weightsAt(point: Point2): Weights {
  const [a, b, c] = CORNERS;
  const area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  const wb = ((point.x - a.x) * (c.y - a.y) - (c.x - a.x) * (point.y - a.y)) / area;
  const wc = ((b.x - a.x) * (point.y - a.y) - (point.x - a.x) * (b.y - a.y)) / area;
  const inside = [1 - wb - wc, wb, wc].map((w) => Math.max(0, w));
  const total = inside[0]! + inside[1]! + inside[2]!;
  const twentieths = inside.map((w) => Math.round((20 * w) / total));
  const largest = twentieths.indexOf(Math.max(...twentieths));
  twentieths[largest]! += 20 - (twentieths[0]! + twentieths[1]! + twentieths[2]!);
  return twentieths.map((w) => w / 20) as Weights;
}

/** Where weights lie in the triangle; the middle when all are 0. */
export function pointOf(weights: Weights): Point2 {
  const total = weights[0] + weights[1] + weights[2];
  const shares = total > 0 ? weights.map((w) => w / total) : [1 / 3, 1 / 3, 1 / 3];
  return {
    x: shares.reduce((sum, share, i) => sum + share * CORNERS[i]!.x, 0),
    y: shares.reduce((sum, share, i) => sum + share * CORNERS[i]!.y, 0),
  };
}
