// The paper's models with the settings of the README's table. The models are not part of this repository.
import { join } from 'node:path';

/** Where the models are, below the folder that S3_SHARED names. */
export const paperModels = 'models/paper';

const volume = ['--input.up', 'y'];
const quality = ['--objectives.support_free', '0.5', '--objectives.surface_quality', '0.5', '--objectives.gamma', '8'];

export const jobs = [
  { name: 'ring', label: 'ring, SF', file: 'ring.tet', flags: [...volume] },
  { name: 'topopt', label: 'topopt, SF', file: 'topopt.tet', flags: [...volume] },
  { name: 'ankle', label: 'ankle, SF 0.5 SQ 0.5, γ 8°', file: 'ankle.tet', flags: [...volume, ...quality] },
  { name: 'bunny', label: 'bunny (197k tets asked), SF 0.5 SQ 0.5, γ 8°', file: 'bunny.off', flags: ['--mesh.target_tets', '197000', ...quality] },
  { name: 'topopt-sr', label: 'topopt, SF 0.7 SR 0.3', file: 'topopt.tet', stress: 'topopt_stress.csv', flags: [...volume, '--objectives.support_free', '0.7', '--objectives.strength', '0.3'] },
];

/** Flags of `s3slice run` for a job whose files are in `models`. */
export function runFlags(job, models) {
  const flags = [...job.flags, '--nozzle.diameter', '1'];
  if (job.stress) flags.push('--strength.stress_file', join(models, job.stress));
  return flags;
}
