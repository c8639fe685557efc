// Exact welding: points with equal coordinates become one vertex.
#pragma once
#include <vector>

#include "base/types.h"

namespace s3 {

/// Numbers points in the order of their first appearance; equal coordinates get equal numbers (−0
/// equals 0).
class Welder {
 public:
  explicit Welder(std::size_t expected_points = 0);
  /// @param p  finite
  /// @return the vertex that stands for p
  Index add(const Vec3& p);
  /// #V×3: the distinct points so far; leaves the welder empty.
  Points take();

 private:
  std::size_t slot_of(const Vec3& p) const;
  void grow();

  std::vector<double> coordinates_;
  std::vector<Index> slots_;  // open addressing, −1 free; a power of two long
};

}  // namespace s3
