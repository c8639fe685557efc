#include "math/morton.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace s3 {

namespace {

constexpr double kCells = 2097151;  // 2^21 − 1 per axis: three of them fill 63 bits

// Moves bit i to bit 3i.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

}  // namespace

std::vector<Index> morton_order(const Points& points) {
  std::vector<std::pair<std::uint64_t, Index>> codes(static_cast<std::size_t>(points.rows()));
  if (codes.empty()) return {};
  const Vec3 low = points.colwise().minCoeff();
  // One scale for all axes, so that cells are cubes; a single point has no extent.
  const double extent = (points.colwise().maxCoeff() - low.transpose()).maxCoeff();
  const double scale = extent > 0 ? kCells / extent : 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const double cell = std::clamp((points(i, k) - low[k]) * scale, 0.0, kCells);
      code |= spread(static_cast<std::uint64_t>(cell)) << k;
    }
    codes[static_cast<std::size_t>(i)] = {code, static_cast<Index>(i)};
  }
  std::sort(codes.begin(), codes.end());
  std::vector<Index> order(codes.size());
  for (std::size_t i = 0; i < codes.size(); ++i) order[i] = codes[i].second;
  return order;
}

}  // namespace s3
