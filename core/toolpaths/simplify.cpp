#include "toolpaths/simplify.h"

#include <algorithm>
#include <utility>

namespace s3 {
namespace {

double distance_to_chord(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - (a + t * ab)).norm();
}

}  // namespace

std::vector<char> find_corners(const Points& points, double tolerance) {
  const Eigen::Index n = points.rows();
  std::vector<char> corner(static_cast<std::size_t>(n), 0);
  corner.front() = corner.back() = 1;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> open = {{0, n - 1}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    double worst = tolerance;
    Eigen::Index split = -1;
    for (Eigen::Index i = a + 1; i < b; ++i) {
      const double d = distance_to_chord(points.row(i), points.row(a), points.row(b));
      if (d > worst) worst = d, split = i;
    }
    if (split < 0) continue;
    corner[static_cast<std::size_t>(split)] = 1;
    open.emplace_back(a, split);
    open.emplace_back(split, b);
  }
  return corner;
}

std::vector<char> find_path_corners(const Path& path, double tolerance) {
  const Eigen::Index n = path.points.rows(), count = n + (path.closed ? 1 : 0);
  Points place(count, 3), profile(count, 3);
  double along = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    place.row(i) = path.points.row(i % n);
    if (i > 0) along += (place.row(i) - place.row(i - 1)).norm();
    profile.row(i) << along, path.width(i % n), 0;
  }
  std::vector<char> corner = find_corners(place, tolerance);
  const std::vector<char> bend = find_corners(profile, tolerance);
  for (std::size_t i = 0; i < corner.size(); ++i) corner[i] = corner[i] || bend[i];
  return corner;
}

void simplify(Path& path, double tolerance) {
  const Eigen::Index n = path.points.rows();
  if (n < 3) return;
  const std::vector<char> corner = find_path_corners(path, tolerance);
  std::vector<Eigen::Index> keep;
  for (Eigen::Index i = 0; i < n; ++i)
    if (corner[static_cast<std::size_t>(i)]) keep.push_back(i);
  if (keep.size() < (path.closed ? 3u : 2u)) return;
  path = path_through(path, keep);
}

}  // namespace s3
