#include "mesh/resting_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mesh/planar_hull.h"
#include "mesh/tri_mesh.h"

namespace s3 {
namespace {

constexpr int kMostRolls = 60;
constexpr double kTouch = 1e-6;  // of the diagonal: points this far above the table touch it

}  // namespace

std::optional<Vec3> resting_pose(const Points& vertices, const Vec3& center_of_mass, Vec3 up) {
  const double touch = kTouch * bounding_box(vertices).diagonal();
  Eigen::VectorXd height;
  for (int roll = 0; roll < kMostRolls; ++roll) {
    height.noalias() = vertices * up;
    const double low = height.minCoeff();
    const Vec3 u = up.unitOrthogonal(), v = up.cross(u);
    const auto flat = [&](const Vec3& p) { return Vec2(p.dot(u), p.dot(v)); };
    std::vector<Vec2> contact;
    for (Eigen::Index i = 0; i < vertices.rows(); ++i)
      if (height[i] <= low + touch) contact.push_back(flat(vertices.row(i).transpose()));
    const Vec2 center = flat(center_of_mass);
    const HullBorder border = nearest_border(convex_hull(std::move(contact)), center);
    if (border.inside >= 0) return up;

    // Tips over the nearest point of the contact towards the centre of mass, until the next point
    // touches: one at height h and `ahead` of the pivot does so after the angle arccot(ahead/h).
    const Vec2 way = center - border.nearest;
    if (way.norm() <= touch) return std::nullopt;
    const Vec2 direction = way.normalized();
    const Vec3 forward = direction.x() * u + direction.y() * v;
    const double pivot = direction.dot(border.nearest);
    double cotangent = -std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < vertices.rows(); ++i)
      if (height[i] > low + touch)
        cotangent = std::max(cotangent, (vertices.row(i).dot(forward) - pivot) / (height[i] - low));
    if (!std::isfinite(cotangent)) return std::nullopt;  // everything touches: a flat sheet
    const double angle = std::atan2(1, cotangent);
    up = (std::cos(angle) * up - std::sin(angle) * forward).normalized();
  }
  return std::nullopt;
}

}  // namespace s3
