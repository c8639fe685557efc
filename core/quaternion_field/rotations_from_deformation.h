// Step (2) of the overview (Sec. 2.3): the rotation of every tet from M to M^d, as quaternions.
#pragma once
#include "base/context.h"
#include "base/types.h"
#include "mesh/tet_mesh.h"

namespace s3 {

/// The print direction of a rotation in the rest frame: d = R(q)⁻¹ d_p. `q` as a stored row (x y z
/// w), unit.
Vec3 print_direction_of(const Eigen::Ref<const Eigen::Matrix<double, 1, 4>>& q);

/// #T×4 identity rotations: planar layers.
Quats identity_rotations(Index tet_count);

/// The closest rotation to each tet's deformation gradient, in the sign nearest to `previous`
/// (#T×4). A flat or inverted tet gives one of its closest rotations, never a reflection.
/// @param deformed  #V×3, M^d, mm
Quats rotations_from_deformation(const TetMesh& rest, const Points& deformed, const Quats& previous,
                                 Context& ctx);

/// Chooses between q and −q, which are the same rotation, so that neighbours agree wherever a walk
/// over the faces allows it. The first tet of each component keeps its sign.
void align_signs(const TetMesh& rest, Quats& rotation);

/// Face pairs with ‖q_i − q_j‖ over `threshold`, up to sign: incompatible in the sense of
/// Sec. 3.3.1.
Index incompatible_pairs(const TetMesh& rest, const Quats& rotation, double threshold = 0.12);

}  // namespace s3
