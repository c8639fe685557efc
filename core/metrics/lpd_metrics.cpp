#include "metrics/lpd_metrics.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace s3 {
namespace {

// The bounds of report.json; a job may optimise for others, its figures stay comparable.
constexpr double kOverhangDeg = 45;
constexpr double kQualityDeg = 10;
constexpr double kStrengthDeg = 10;
// Directions come from rounded arithmetic: a face at exactly 45° must not be a violation.
constexpr double kAngleTolerance = 1e-6;  // degrees

// Exact near 0° and 180°, where acos is not.
double angle_deg(const Vec3& a, const Vec3& b) {
  return degrees(std::atan2(a.cross(b).norm(), a.dot(b)));
}

double to_axis_deg(const Vec3& axis, const Vec3& d) {
  const double angle = angle_deg(axis, d);
  return std::min(angle, 180 - angle);
}

template <class Predicate>
std::optional<double> share_percent(const std::vector<WeightedValue>& angles, Predicate&& accepts) {
  double accepted = 0, total = 0;
  for (const WeightedValue& a : angles) {
    total += a.weight;
    if (accepts(a.value)) accepted += a.weight;
  }
  if (!(total > 0)) return std::nullopt;
  return 100 * accepted / total;
}

}  // namespace

FaceAngle face_angle(const Vec3& normal, const Vec3& direction) {
  if (!(direction.squaredNorm() > 0)) return {180, 45};
  return {angle_deg(normal, direction), to_axis_deg(normal, direction)};
}

LpdAngles lpd_angles(const TetMesh& rest, const ObjectiveField& objectives,
                     const StressField* stress, const Directions& print_direction) {
  LpdAngles angles;
  for (Eigen::Index f = 0; f < rest.boundary_faces.rows(); ++f) {
    const auto i = static_cast<std::size_t>(f);
    if (objectives.face_exempt[i]) continue;
    const Vec3 n = objectives.face_normal.row(f);
    const Vec3 d = print_direction.row(rest.boundary_face_tet[i]);
    const double area = objectives.face_area(f);
    const FaceAngle angle = face_angle(n, d);
    angles.support_free.push_back({angle.support_free_deg, area});
    angles.surface_quality.push_back({angle.surface_quality_deg, area});
    if (!objectives.face_in_region.empty() && objectives.face_in_region[i])
      angles.surface_quality_region.push_back({angle.surface_quality_deg, area});
  }
  if (stress == nullptr) return angles;
  for (const Index t : stress->critical_tets) {
    const Vec3 tau = stress->principal.row(t);
    const Vec3 d = print_direction.row(t);
    angles.strength.push_back({d.squaredNorm() > 0 ? 90 - to_axis_deg(tau, d) : 90, 1});
  }
  return angles;
}

void lpd_metrics(const LpdAngles& angles, Metrics& metrics) {
  // Eq. 1: d·n + sin α ≥ 0, i.e. an angle of at most 90° + α between them.
  constexpr double kLargest = 90 + kOverhangDeg + kAngleTolerance;
  metrics.support_free_area_percent =
      share_percent(angles.support_free, [](double a) { return a <= kLargest; });
  const auto smooth = [](double a) {
    return a <= kQualityDeg + kAngleTolerance || a >= 90 - kQualityDeg - kAngleTolerance;
  };
  metrics.surface_quality_area_percent = share_percent(angles.surface_quality, smooth);
  metrics.surface_quality_region_percent = share_percent(angles.surface_quality_region, smooth);
  metrics.strength_critical_percent =
      share_percent(angles.strength, [](double a) { return a <= kStrengthDeg + kAngleTolerance; });

  double violation = 0, area = 0;
  for (const WeightedValue& a : angles.support_free) {
    area += a.weight;
    if (a.value > kLargest) violation += a.weight * (a.value - 90 - kOverhangDeg);
  }
  metrics.support_free_mean_violation_deg.reset();
  if (area > 0) metrics.support_free_mean_violation_deg = violation / area;
}

int count_foldovers(const Points& deformed, const Tets& tets) {
  int count = 0;
  for (Index t = 0; t < tets.rows(); ++t)
    if (!(tet_volume(deformed, tets, t) > 0)) ++count;
  return count;
}

}  // namespace s3
