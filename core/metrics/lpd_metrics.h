// How well print directions meet the objectives (Sec. 5.2.2, Figs. 7, 10–13): angles on faces and
// critical tets.
#pragma once
#include <vector>

#include "base/types.h"
#include "fea/stress.h"
#include "mesh/tet_mesh.h"
#include "metrics/metrics.h"
#include "metrics/svg_plot.h"
#include "objectives/objectives.h"

namespace s3 {

/// What the paper's histograms show, before it is put into bins: angles in degrees, weighted by the
/// area of a face (mm²) or 1 for a tet.
struct LpdAngles {
  std::vector<WeightedValue>
      support_free;  // angle between n and d, in [0, 180]: up to 135° prints without support
  std::vector<WeightedValue>
      surface_quality;  // angle between ±n and d, in [0, 90]: best near 0° and near 90°
  std::vector<WeightedValue> surface_quality_region;  // those in the region for SQ
  std::vector<WeightedValue>
      strength;  // angle between ±τ_max and the layer, in [0, 90]: best near 0°
};

/// How one face meets its layer, degrees; the worst of each kind where d = 0 (no direction).
struct FaceAngle {
  double support_free_deg;     // between n and d, in [0, 180]
  double surface_quality_deg;  // between ±n and d, in [0, 90]
};
FaceAngle face_angle(const Vec3& normal, const Vec3& direction);

/// Angles of all boundary faces off the plate, and of the critical tets.
/// @param stress           may be null: then no tet is critical
/// @param print_direction  #T×3 unit vectors. A zero row (no direction) counts as the worst angle
/// of each kind
LpdAngles lpd_angles(const TetMesh& rest, const ObjectiveField& objectives,
                     const StressField* stress, const Directions& print_direction);

/// Fills support_free_*, surface_quality_* and strength_* of the metrics from the angles; the
/// bounds are the contract's (45°, 10°, 10°), whatever the job asked for. Nothing to count leaves a
/// figure empty.
void lpd_metrics(const LpdAngles& angles, Metrics& metrics);

/// Tets whose volume is not positive at the given positions (#V×3).
int count_foldovers(const Points& deformed, const Tets& tets);

}  // namespace s3
