// The inner loop: compatible rotations by local projection and global blending (Sec. 3.2, Eq. 8).
#pragma once
#include <vector>

#include "base/context.h"
#include "base/types.h"
#include "math/sparse_solver.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"

namespace s3 {

struct RotationField {
  Quats rotation;         // #T×4, q_e: turns the rest tet so that its print direction becomes z: R(q) d = d_p
  Quats target_rotation;  // #T×4, q_e^t of the last projection
};

struct QuaternionFieldParams {
  int inner_iterations = 10;
  double alpha_margin = 0.05;  // rad: targets stay this far inside their region
  double tolerance = 1e-4;     // of each blend solve
};

/// Runs the inner loop from the given rotations.
/// @param rotation       #T×4 start (identity for planar layers)
/// @param smooth_weight  #N = w_s of Eq. 8 for each of rest.face_pairs
/// @param keep_scale     factor on w_k of Eq. 9 (the short start scales it with the mean edge length)
RotationField optimize_quaternion_field(const TetMesh& rest, const ObjectiveField& objectives,
                                        const ObjectiveParams& objective_params, const Quats& rotation,
                                        const Values& smooth_weight, double keep_scale,
                                        const QuaternionFieldParams& params, Context& ctx);

}  // namespace s3
