// Printed beads as round tubes, sorted into a grid: how far is a point from the nearest of them?
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "base/types.h"

namespace s3 {

struct Tube {
  Vec3 begin, end;  // of its axis, mm
  double radius;    // mm
};

class TubeGrid {
 public:
  /// @param tubes  at least one
  explicit TubeGrid(std::vector<Tube> tubes);

  /// The least of (distance to the axis − radius) over all tubes: negative inside.
  double signed_distance(const Vec3& p) const;

 private:
  int coordinate(double value, int k) const;
  std::size_t index(int i, int j, int k) const;
  template <class Body>
  void for_each_cell(Body&& body) const;
  template <class Body>
  void visit_ring(const std::array<int, 3>& centre, int ring, Body&& body) const;
  template <class Body>
  void visit_cell(std::size_t cell, Body&& body) const;

  std::vector<Tube> tubes_;
  Vec3 low_, high_;
  double largest_radius_ = 0;
  double cell_ = 1;
  std::array<int, 3> counts_ = {1, 1, 1};
  std::vector<std::size_t> begin_;      // offsets into entries_ by cell
  std::vector<std::uint32_t> entries_;  // tubes whose axis' box touches the cell
};

}  // namespace s3
