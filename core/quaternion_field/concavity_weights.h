// Concave regions of the layers: where the head would gouge (Sec. 2.2.1) and the smoothness weights
// that flatten them (Sec. 3.3.2, Eqs. 10 and 11).
#pragma once
#include "base/types.h"
#include "mesh/tet_mesh.h"

namespace s3 {

/// The signed angle ω of Eq. 10 between the print directions of each face pair: negative where the
/// layer through the pair's shared face is a valley seen from the nozzle, positive where it is a
/// ridge.
///
/// For a continuous, piecewise linear G the jump of ∇G stands on the shared face, so the sign
/// follows from the face's normal m from the first tet to the second: concave when (n_R − n_L)·m <
/// 0.
/// @param print_direction  #T×3 unit vectors; a zero row (no direction) gives ω = 0 for its pairs
/// @return #N in rest.face_pairs' order, rad, in [−π, π]
Values concave_angles(const TetMesh& rest, const Directions& print_direction);

/// Clearance of a head that stands along the layer's normal: 90° − θ/2 for a cone of apex angle θ,
/// rad.
double head_clearance(double head_cone_angle);

/// Face pairs that are concave by more than `angle` (rad, positive).
Index count_concave_over(const Values& omega, double angle);

/// Face pairs that are concave by more than the head's clearance: local collisions.
/// @param head_cone_angle  apex angle θ, rad
Index gouging_pairs(const Values& omega, double head_cone_angle);

/// w_s of Eq. 11: 1 + |ω|^p on concave pairs, 1 on all others.
Values concavity_weights(const Values& omega, double exponent);

}  // namespace s3
