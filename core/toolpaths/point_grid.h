// Points in cubic cells, for finding all within one cell width of a place.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/types.h"

namespace s3 {

class PointGrid {
 public:
  /// @param cell  mm: everything within this distance of a place is visited
  explicit PointGrid(double cell) : scale_(1 / cell) {}

  void add(const Vec3& point) { points_.push_back(point); }
  const Vec3& point(Index i) const { return points_[static_cast<std::size_t>(i)]; }

  /// Call once after the last add().
  void finish() {
    std::size_t slots = 16;
    while (slots < points_.size()) slots *= 2;
    mask_ = slots - 1;
    begin_.assign(slots + 1, 0);
    std::vector<std::size_t> slot(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto c = cell_of(points_[i]);
      slot[i] = slot_of(c[0], c[1], c[2]);
      ++begin_[slot[i] + 1];
    }
    for (std::size_t s = 0; s < slots; ++s) begin_[s + 1] += begin_[s];
    std::vector<Index> fill(begin_.begin(), begin_.end() - 1);
    order_.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i)
      order_[static_cast<std::size_t>(fill[slot[i]]++)] = static_cast<Index>(i);
  }

  /// visitor(i) for every point in the 27 cells around `place`, and possibly others (the caller
  /// measures distances). A point may be visited twice when two cells share a slot.
  template <class Visitor>
  void visit(const Vec3& place, Visitor&& visitor) const {
    if (points_.empty()) return;
    const auto c = cell_of(place);
    for (std::int64_t x = c[0] - 1; x <= c[0] + 1; ++x)
      for (std::int64_t y = c[1] - 1; y <= c[1] + 1; ++y)
        for (std::int64_t z = c[2] - 1; z <= c[2] + 1; ++z) {
          const std::size_t slot = slot_of(x, y, z);
          for (Index i = begin_[slot]; i < begin_[slot + 1]; ++i)
            visitor(order_[static_cast<std::size_t>(i)]);
        }
  }

 private:
  std::array<std::int64_t, 3> cell_of(const Vec3& p) const {
    return {static_cast<std::int64_t>(std::floor(p.x() * scale_)),
            static_cast<std::int64_t>(std::floor(p.y() * scale_)),
            static_cast<std::int64_t>(std::floor(p.z() * scale_))};
  }
  std::size_t slot_of(std::int64_t x, std::int64_t y, std::int64_t z) const {
    std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15u ^
                      static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4Fu ^
                      static_cast<std::uint64_t>(z) * 0x165667B19E3779F9u;
    h ^= h >> 29;
    return static_cast<std::size_t>(h) & mask_;
  }

  double scale_;
  std::size_t mask_ = 0;
  std::vector<Vec3> points_;
  std::vector<Index> begin_, order_;
};

}  // namespace s3
