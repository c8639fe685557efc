#include "toolpaths/toolpaths.h"

#include <algorithm>
#include <numeric>

namespace s3 {

const char* path_kind_name(PathKind kind) {
  switch (kind) {
    case PathKind::wall:
      return "wall";
    case PathKind::infill:
      return "infill";
    case PathKind::gap_fill:
      return "gap_fill";
  }
  return "wall";
}

Path path_through(const Path& path, const std::vector<Eigen::Index>& points) {
  Path result;
  result.closed = path.closed;
  result.kind = path.kind;
  result.points = path.points(points, Eigen::all);
  result.normals = path.normals(points, Eigen::all);
  result.thickness = path.thickness(points);
  result.width = path.width(points);
  return result;
}

void ShareHistogram::add(double position, double weight) {
  const double bin = std::clamp(position, 0.0, 1.0) * static_cast<double>(kBins);
  bins[std::min(static_cast<std::size_t>(bin), kBins - 1)] += weight;
}

void ShareHistogram::add(const ShareHistogram& other) {
  for (std::size_t i = 0; i < kBins; ++i) bins[i] += other.bins[i];
}

double ShareHistogram::total() const {
  return std::accumulate(bins.begin(), bins.end(), 0.0);
}

double ShareHistogram::quantile(double share) const {
  double left = share * total();
  for (std::size_t i = 0; i < kBins; ++i) {
    if (left <= bins[i] && bins[i] > 0)
      return (static_cast<double>(i) + left / bins[i]) / static_cast<double>(kBins);
    left -= bins[i];
  }
  return 1;
}

double ShareHistogram::between(double low, double high) const {
  double inside = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    const double from = static_cast<double>(i), position = static_cast<double>(kBins);
    inside += bins[i] * std::clamp(high * position - from, 0.0, 1.0) -
              bins[i] * std::clamp(low * position - from, 0.0, 1.0);
  }
  return inside / total();
}

}  // namespace s3
