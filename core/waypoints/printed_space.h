// The space that printed beads fill so far, and ways over it.
#pragma once
#include <unordered_map>
#include <vector>

#include "base/types.h"

namespace s3 {

/// Points on the top of printed beads in cubic cells; grows as the print does.
class PrintedSpace {
 public:
  /// @param reach  mm: up to which distances are asked for
  explicit PrintedSpace(double reach) : scale_(1 / reach), reach_(reach) {}

  void add(const Vec3& point);
  /// Distance to the nearest point, at most `reach`.
  double distance(const Vec3& place) const;
  /// Highest z of all points, 0 before the first.
  double top() const { return top_; }

 private:
  struct Key {
    std::int64_t x, y, z;
    bool operator==(const Key&) const = default;
  };
  struct Hash {
    std::size_t operator()(const Key& k) const;
  };
  Key key_of(const Vec3& p) const;

  double scale_, reach_, top_ = 0;
  std::unordered_map<Key, std::vector<Vec3>, Hash> cells_;  // looked up only, never walked through
};

/// A way for the tip.
struct Travel {
  std::vector<Vec3> points;  // between start and end, without both
  bool clear =
      true;  // false: no way was found on which nothing printed is nearer than the clearance
};

/// From `start` to `end`, leaving and arriving along the normals.
/// @param clearance  mm
Travel find_travel(const PrintedSpace& space, const Vec3& start, const Vec3& start_normal,
                   const Vec3& end, const Vec3& end_normal, double clearance);

}  // namespace s3
