// Corners first, then equal arc length between them.
#include "waypoints/resample.h"

#include "toolpaths/simplify.h"

#include <algorithm>
#include <cmath>

namespace s3 {
Path resample(const Path& path, double spacing, double tolerance) {
  Path result;
  result.kind = path.kind;
  const Eigen::Index given = path.points.rows();
  if (given < 2) return result;
  const Eigen::Index n = given + (path.closed ? 1 : 0);
  Points points(n, 3);
  std::vector<double> along(static_cast<std::size_t>(n), 0);
  for (Eigen::Index i = 0; i < n; ++i) {
    points.row(i) = path.points.row(i % given);
    if (i > 0)
      along[static_cast<std::size_t>(i)] =
          along[static_cast<std::size_t>(i - 1)] + (points.row(i) - points.row(i - 1)).norm();
  }
  // Half the tolerance for the corners leaves the other half to the points between them.
  const std::vector<char> corner = find_path_corners(path, 0.5 * tolerance);
  std::vector<double> places = {0};
  for (Eigen::Index i = 1, from = 0; i < n; ++i) {
    if (!corner[static_cast<std::size_t>(i)]) continue;
    const double begin = along[static_cast<std::size_t>(from)],
                 length = along[static_cast<std::size_t>(i)] - begin;
    const int steps = std::max(1, static_cast<int>(std::ceil(length / spacing - 1e-9)));
    for (int k = 1; k <= steps; ++k) places.push_back(begin + length * k / steps);
    from = i;
  }
  const auto count = static_cast<Eigen::Index>(places.size());
  result.points.resize(count, 3);
  result.normals.resize(count, 3);
  result.thickness.resize(count);
  result.width.resize(count);
  Eigen::Index piece = 0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double place = places[static_cast<std::size_t>(k)];
    while (piece + 2 < n && along[static_cast<std::size_t>(piece + 1)] < place) ++piece;
    const double length =
        along[static_cast<std::size_t>(piece + 1)] - along[static_cast<std::size_t>(piece)];
    const double t =
        length > 0 ? std::clamp((place - along[static_cast<std::size_t>(piece)]) / length, 0.0, 1.0)
                   : 0.0;
    const Eigen::Index a = piece % given, b = (piece + 1) % given;
    result.points.row(k) = (1 - t) * path.points.row(a) + t * path.points.row(b);
    const Vec3 normal = (1 - t) * path.normals.row(a) + t * path.normals.row(b);
    result.normals.row(k) =
        normal.squaredNorm() > 0 ? Vec3(normal.normalized()) : Vec3(path.normals.row(a));
    result.thickness(k) = (1 - t) * path.thickness(a) + t * path.thickness(b);
    result.width(k) = (1 - t) * path.width(a) + t * path.width(b);
  }
  return result;
}

}  // namespace s3
