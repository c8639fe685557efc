// Scale-controlled deformation: stitches the rotated tets together (Sec. 4.1, Eq. 12).
#pragma once
#include <memory>
#include <vector>

#include "base/context.h"
#include "base/types.h"
#include "mesh/tet_mesh.h"

namespace s3 {

struct ScaleControlParams {
  double rigidity = 1.0;             // w_r
  double scale_compatibility = 6.0;  // w_c
  double tolerance = 1e-4;           // of the linear system, relative to its right-hand side
  int max_iterations = 500;
};

struct Deformation {
  Points vertices;  // #V×3, M^d, mm: z = 0 on the plate contact
  Points scales;    // #T×3, the diagonal of S_e, along the axes of the rest frame
  int iterations = 0;
  bool converged = true;
};

/// M^d = M: where the outer loop starts.
Deformation undeformed(const TetMesh& rest);

/// Solves Eq. 12 for positions and scales jointly, for one mesh and any number of rotation fields.
///
/// Independent of the model's size and of its mesh: lengths count in mean edges, tets by their
/// volume, and w_c grows with the square of the resolution, so that a smooth field of scales costs
/// the same on every mesh. (Eq. 12 as printed weighs position against rigidity by mm², and scale
/// against rigidity by the number of tets.) The plate contact keeps z = 0. Each component is held
/// in place, sideways and where it does not touch the plate also in z, by one vertex that stays
/// where it is.
class ScaleControlledDeformer {
 public:
  /// Builds matrices and preconditioners, which do not depend on the rotations.
  /// @param vertex_on_plate  #V
  ScaleControlledDeformer(const TetMesh& rest, const std::vector<char>& vertex_on_plate,
                          const ScaleControlParams& params, Context& ctx);
  ~ScaleControlledDeformer();

  /// @param rotation  #T×4 unit quaternions
  /// @param start     warm start: the last result, or undeformed()
  /// @throws Cancelled
  Deformation deform(const Quats& rotation, const Deformation& start, Context& ctx) const;

 private:
  struct System;
  std::unique_ptr<System> system_;
};

}  // namespace s3
