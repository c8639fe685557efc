// ∇ of piecewise linear fields, its adjoint, and the matrices made of both: precomputed for solves
// that visit every tet dozens of times.
#pragma once
#include <vector>

#include "base/context.h"
#include "base/types.h"
#include "math/sparse_solver.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"

namespace s3 {

class FieldOperators {
 public:
  FieldOperators(const TetMesh& rest, Context& ctx);

  /// #T×3: ∇ of the field with these vertex values.
  void gradients(const Values& value, Points& gradient, Context& ctx) const;

  /// #V: the adjoint of gradients(): Σ over the tets of a vertex of (its hat gradient)·(the tet's
  /// row).
  void adjoint(const Points& tet_vector, Values& vertex_sum, Context& ctx) const;

  Vec3 gradient(const Values& value, Index t) const {
    const double v0 = value(rest_.tets(t, 0));
    return hat(t, 1) * (value(rest_.tets(t, 1)) - v0) + hat(t, 2) * (value(rest_.tets(t, 2)) - v0) +
           hat(t, 3) * (value(rest_.tets(t, 3)) - v0);
  }

  double volume(Index t) const { return volume_(t); }  // mm³
  double face_weight(Index p) const {
    return face_weight_(p);
  }  // mm³: a face's share of the volume
  Vec3 face_normal(Index p) const {
    return face_normal_.row(p);
  }  // from the pair's first tet to its second
  /// The pair across local face f, −1 on the boundary.
  Index pair_across(Index t, int f) const { return pair_across_(t, f); }

  /// Some tet uses this vertex.
  bool in_use(Index v) const { return corner_begin_[v + 1] > corner_begin_[v]; }

  /// Calls visit(t) for the tets of a vertex, ascending.
  template <class Visit>
  void for_each_tet_around(Index v, Visit&& visit) const {
    for (Index c = corner_begin_[v]; c < corner_begin_[v + 1]; ++c) visit(corners_[c] / 4);
  }

  /// Σ_t tet_weight(t) ‖∇G_t‖² + Σ_p pair_weight(p) (jump of ∇G across p)², as a matrix on the free
  /// vertices.
  /// @param free_index  #V: row of each vertex, −1 where its value is fixed; rows in vertex order
  /// @param pair_weight #N; empty for none
  SparseMatrix energy(const Values& tet_weight, const Values& pair_weight,
                      const std::vector<Index>& free_index, Context& ctx) const;

 private:
  Vec3 hat(Index t, int i) const { return hat_.row(3 * static_cast<Eigen::Index>(t) + i - 1); }

  const TetMesh& rest_;
  Points hat_;  // 3T×3: hat gradients of corners 1 to 3; that of corner 0 is minus their sum
  Values volume_, face_weight_;
  Directions face_normal_;
  Tets pair_across_;
  std::vector<Index> corner_begin_, corners_;  // 4 t + i grouped by vertex, ascending
};

/// The vertices whose value is given: the plate contact, and the lowest vertex of each component
/// that is not on the plate. Their value is the height above the bottom, 0 on a flat contact.
struct Anchors {
  std::vector<Index> free_index;  // #V: numbers the other vertices, −1 on anchors
  Index free_count = 0;
  Values planar;  // #V: height above the bottom, G of planar layers

  /// The rows of the free vertices, as a right-hand side.
  void gather_free(const Values& vertex_values, Block& rows) const;
  /// Adds a solution to the values of the free vertices.
  void add_free(const Block& rows, Values& vertex_values) const;
};

Anchors find_anchors(const TetMesh& rest, const ObjectiveField& objectives);

}  // namespace s3
