// A block that leans over, by 50° unless told otherwise, as a .tet file: small, quick, and something to do for support-free layers.
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const root = join(dirname(fileURLToPath(import.meta.url)), '..', '..');

/** The six tets of a cell: one for each order in which the axes are walked from its lowest corner to the opposite one. */
const ORDERS = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/**
 * @param {[number, number, number]} cells
 * @param {[number, number, number]} size  mm
 * @param {number} jitter  mm: how far vertices are moved off the grid, where many things are exactly as good as each other
 * @param {number} lean  tangent of the angle; 0 stands upright
 */
export function leaningBlock(cells = [4, 3, 5], size = [8, 6, 10], jitter = 0, lean = 1.2) {
  const counts = cells.map((n) => n + 1);
  const id = (at) => at[0] + counts[0] * (at[1] + counts[1] * at[2]);
  const vertices = [];
  const tets = [];
  for (let k = 0; k <= cells[2]; ++k)
    for (let j = 0; j <= cells[1]; ++j)
      for (let i = 0; i <= cells[0]; ++i) {
        // A fractional part of multiples of an irrational number: even, and the same everywhere.
        const off = (/** @type {number} */ axis) => jitter * ((((vertices.length * 3 + axis + 1) * 0.6180339887) % 1) - 0.5);
        const [x, y, z] = [i, j, k].map((n, axis) => (size[axis] * n) / cells[axis] + (k > 0 || axis < 2 ? off(axis) : 0));
        vertices.push([x + lean * Math.max(0, z - 2), y, z].map((value) => Number(value.toFixed(6))));
        if (i < cells[0] && j < cells[1] && k < cells[2])
          for (const order of ORDERS) {
            const at = [i, j, k];
            tets.push([id(at), ...order.map((axis) => (++at[axis], id(at)))]);
          }
      }
  const lines = [`${vertices.length} vertices`, `${tets.length} tets`];
  for (const p of vertices) lines.push(p.join(' '));
  for (const t of tets) lines.push(['4', ...t].join(' '));
  return new TextEncoder().encode(lines.join('\n') + '\n');
}
