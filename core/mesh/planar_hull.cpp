// Andrew 1979, "Another efficient algorithm for convex hulls in two dimensions".
#include "mesh/planar_hull.h"

#include <algorithm>
#include <limits>

namespace s3 {
namespace {

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(), [](const Vec2& a, const Vec2& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vec2> hull;
  const auto add = [&hull](const Vec2& p, std::size_t kept) {
    while (hull.size() > kept && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
      hull.pop_back();
    hull.push_back(p);
  };
  for (const Vec2& p : points) add(p, 1);
  const std::size_t lower = hull.size();
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.pop_back();  // the first point again
  return hull;
}

HullBorder nearest_border(const std::vector<Vec2>& hull, const Vec2& point) {
  HullBorder border;
  double best = std::numeric_limits<double>::infinity();
  bool inside = hull.size() > 2;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2 &a = hull[i], &b = hull[(i + 1) % hull.size()];
    const Vec2 ab = b - a, ap = point - a;
    const double length2 = ab.squaredNorm();
    const double s = length2 > 0 ? std::clamp(ap.dot(ab) / length2, 0.0, 1.0) : 0.0;
    const double distance = (ap - s * ab).norm();
    inside = inside && cross(ab, ap) >= 0;
    if (distance >= best) continue;
    best = distance;
    border.nearest = a + s * ab;
  }
  border.inside = inside ? best : -best;
  return border;
}

}  // namespace s3
