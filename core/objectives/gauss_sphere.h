// Points and circles on the unit sphere, where the objectives bound the print direction (Sec. 3.1).
#pragma once
#include <array>
#include <cmath>

#include "base/types.h"

namespace s3 {

/// Angle between two vectors in [0, π]; exact near 0 and π, where acos is not. 0 for a zero vector.
inline double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Any unit vector at a right angle to the unit vector `axis`; a continuous choice almost
/// everywhere.
inline Vec3 any_perpendicular(const Vec3& axis) {
  Eigen::Index smallest;
  axis.cwiseAbs().minCoeff(&smallest);
  return axis.cross(Vec3::Unit(smallest)).normalized();
}

/// The circle {x on the unit sphere : axis·x = offset}; `axis` is a unit vector, |offset| ≤ 1.
struct SphereCircle {
  Vec3 axis;
  double offset;
};

/// The point of the circle that is closest to the unit vector `d`: on the great circle through d
/// and the axis. Where d is ± the axis all points are equally close; the answer is then any one of
/// them.
inline Vec3 closest_on_circle(const SphereCircle& circle, const Vec3& d) {
  const Vec3 across = d - circle.axis.dot(d) * circle.axis;
  const double length = across.norm();
  constexpr double kOnAxis =
      1e-8;  // below it rounding turns `across` by more than its own angle to the axis
  const Vec3 side = length > kOnAxis ? Vec3(across / length) : any_perpendicular(circle.axis);
  return circle.offset * circle.axis + std::sqrt(1 - circle.offset * circle.offset) * side;
}

/// The points where two circles meet: `count` is 0 or 2 (two equal points where they touch).
struct CircleMeeting {
  int count = 0;
  std::array<Vec3, 2> points;
};

inline CircleMeeting meeting_points(const SphereCircle& p, const SphereCircle& q) {
  // x = s a + t b ± u (a × b), with a·x and b·x given; u from |x| = 1.
  const double c = p.axis.dot(q.axis);
  const Vec3 across = p.axis.cross(q.axis);
  const double sin2 = across.squaredNorm();
  constexpr double kParallel = 1e-20;  // circles about one axis coincide or never meet
  if (sin2 < kParallel) return {};
  const double s = (p.offset - c * q.offset) / sin2, t = (q.offset - c * p.offset) / sin2;
  const Vec3 middle = s * p.axis + t * q.axis;
  const double rest = 1 - middle.squaredNorm();
  if (rest < 0) return {};
  const Vec3 step = std::sqrt(rest / sin2) * across;
  return {2, {(middle + step).normalized(), (middle - step).normalized()}};
}

}  // namespace s3
