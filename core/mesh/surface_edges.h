// The edges of any triangles, manifold or not: what inspection and repair walk along.
#pragma once
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "mesh/tri_mesh.h"

namespace s3 {

/// Disjoint sets with path halving; the smaller number leads, so that results do not depend on the
/// order of joins.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  Index find(Index i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  /// @return false where the two were joined already
  bool join(Index i, Index j) {
    i = find(i), j = find(j);
    if (i == j) return false;
    at(std::max(i, j)) = std::min(i, j);
    return true;
  }

 private:
  Index& at(Index i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<Index> parent_;
};

/// One side of a triangle; sorted, the sides of one edge are neighbours.
struct Side {
  Index low, high;  // the edge's vertices
  Index corner;     // 3·triangle + i: from corner i to corner i+1
  bool forward;     // runs from low to high

  Index triangle() const { return corner / 3; }
  Index from() const { return forward ? low : high; }
  Index to() const { return forward ? high : low; }
  bool same_edge(const Side& o) const { return low == o.low && high == o.high; }
  bool operator<(const Side& o) const {
    if (low != o.low) return low < o.low;
    return high != o.high ? high < o.high : corner < o.corner;
  }
};

bool has_repeated_corner(const TriMesh& mesh, Eigen::Index f);

/// Every side, sorted by edge; triangles with a repeated corner have none. Near-linear time.
std::vector<Side> sorted_sides(const TriMesh& mesh);

/// body(begin, end) for the sides of every edge.
template <class Body>
void for_each_edge(const std::vector<Side>& sides, Body&& body) {
  for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
    for (end = begin + 1; end < sides.size() && sides[begin].same_edge(sides[end]);) ++end;
    body(begin, end);
  }
}

/// The corner of the side's triangle at one of its vertices, as 3·triangle + i.
Index corner_at(const TriMesh& mesh, const Side& side, Index vertex);
/// The vertex of the side's triangle that is not on the edge.
Index tip_of(const TriMesh& mesh, const Side& side);

inline Vec3 vertex_of(const TriMesh& mesh, Index v) {
  return mesh.vertices.row(v);
}
Vec3 centroid_of(const TriMesh& mesh, Index f);

/// Every edge has two sides that run in opposite directions.
bool is_closed_and_oriented(const std::vector<Side>& sides);

/// #F: the number of the part that each triangle belongs to, in the order of their first triangles.
/// Parts hang together by edges.
/// @param manifold_only  only edges with exactly two sides join
std::vector<Index> connected_parts(const TriMesh& mesh, const std::vector<Side>& sides,
                                   bool manifold_only, Index& count);

/// Removes triangles; the others keep their order. @param keep  #F
void keep_triangles(TriMesh& mesh, const std::vector<char>& keep);

/// Removes vertices without triangles. @return how many
Index drop_unused_vertices(TriMesh& mesh);

}  // namespace s3
