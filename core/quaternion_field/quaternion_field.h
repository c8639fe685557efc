// The inner loop: compatible rotations by local projection and global blending (Sec. 3.2, Eq. 8).
#pragma once
#include <vector>

#include "base/context.h"
#include "base/types.h"
#include "math/sparse_solver.h"
#include "mesh/tet_mesh.h"
#include "objectives/feasible_region.h"
#include "objectives/objectives.h"

namespace s3 {

struct RotationField {
  Quats rotation;  // #T×4, q_e: turns the rest tet so that its print direction becomes z: R(q) d =
                   // d_p
  Quats target_rotation;  // #T×4, q_e^t of the last projection; equal to the start where no target
                          // holds the tet
  double projection_seconds = 0;  // wall time of the local projections within the call
  int infeasible_tets = 0;        // held tets of which no direction satisfies all objectives
};

struct QuaternionFieldParams {
  int inner_iterations = 10;
  double alpha_margin = 0.05;   // rad: targets stay this far inside their region
  double tolerance = 1e-3;      // of each blend solve
  double conformal_weight = 1;  // factor on w_k where the target is a face's normal (SQ-C, Fig. 5)
};

/// w_k of Eq. 9 for every tet, with the switches of the print directions that `rotation` stands
/// for, and a strong hold on the tets of the plate contact, of which the first layer is flat.
/// @param rotation  #T×4
/// @return #T; 0 where nothing is asked or everything is satisfied
Values keep_weights(const ObjectiveField& objectives, const RegionBounds& bounds,
                    const Quats& rotation, Context& ctx);

/// Runs the inner loop from the given rotations: projects every held tet's print direction into its
/// region, then blends all rotations with one SPD matrix, as often as asked.
/// @param rotation       #T×4 start (identity for planar layers); its switches (Eq. 9) hold for the
/// whole call
/// @param smooth_weight  #N = w_s of Eq. 8 for each of rest.face_pairs
/// @param keep_scale     factor on w_k of Eq. 9 (the short start scales it with the mean edge
/// length)
RotationField optimize_quaternion_field(const TetMesh& rest, const ObjectiveField& objectives,
                                        const ObjectiveParams& objective_params,
                                        const Quats& rotation, const Values& smooth_weight,
                                        double keep_scale, const QuaternionFieldParams& params,
                                        Context& ctx);

}  // namespace s3
