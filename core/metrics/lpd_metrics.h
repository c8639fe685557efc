// How well print directions meet the objectives (Sec. 5.2.2, Figs. 7, 10–13): angles on faces and
// critical tets.
#pragma once
#include <vector>

#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "metrics/metrics.h"
#include "objectives/objectives.h"

namespace s3 {

/// An angle in degrees with the share it stands for (mm² of a face, 1 for a tet).
struct WeightedAngle {
  double angle_deg = 0;
  double weight = 0;
};

/// What the paper's histograms show, before it is put into bins.
struct LpdAngles {
  std::vector<WeightedAngle>
      support_free;  // angle between n and d, in [0, 180]: up to 135° prints without support
  std::vector<WeightedAngle>
      surface_quality;  // angle between ±n and d, in [0, 90]: best near 0° and near 90°
  std::vector<WeightedAngle>
      strength;  // angle between ±τ_max and the layer, in [0, 90]: best near 0°
};

/// Angles of all boundary faces off the plate, and of the critical tets.
/// @param print_direction  #T×3 unit vectors. A zero row (no direction) counts as the worst angle
/// of each kind
LpdAngles lpd_angles(const TetMesh& rest, const ObjectiveField& objectives,
                     const Directions& print_direction);

/// Fills support_free_*, surface_quality_* and strength_* of the metrics from the angles; the
/// bounds are the contract's (45°, 10°, 10°), whatever the job asked for. Nothing to count leaves a
/// figure empty.
void lpd_metrics(const LpdAngles& angles, Metrics& metrics);

/// Tets whose volume is not positive at the given positions (#V×3).
int count_foldovers(const Points& deformed, const Tets& tets);

}  // namespace s3
