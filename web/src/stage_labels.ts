// Stages as people call them.
import type { Stage } from '../../wasm/index.js';

export const STAGE_LABELS: Record<Stage, string> = {
  mesh: 'Surface', tetrahedralize: 'Volume mesh', fea: 'Stress', objectives: 'Objectives', outer_loop: 'Layer field', layers: 'Layers',
  toolpaths: 'Toolpaths', waypoints: 'Waypoints', motion: 'Machine moves', export: 'Programs', metrics: 'Figures, planar layers',
};
