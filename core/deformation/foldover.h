// No foldovers: every tet of M^d gets a positive volume, guaranteed (the paper's limitation in
// Sec. 5.4.4).
#pragma once
#include <vector>

#include "base/context.h"
#include "base/types.h"
#include "mesh/tet_mesh.h"

namespace s3 {

/// A tet counts as folded when its volume in M^d is below this share of its rest volume. Above 0,
/// so that what is left is far from rounding errors and its layers have a thickness.
inline constexpr double kLeastVolumeShare = 1e-3;

/// Volume in M^d over rest volume of every tet: det F. #T.
Values volume_shares(const TetMesh& rest, const Points& deformed);

struct FoldoverReport {
  Index found = 0;  // folded tets on entry
  Index moved_vertices = 0;
  double kept_share = 1;  // 1, or how much of the deformation is left after the last resort
};

/// Unfolds M^d in place. On exit every tet has a positive volume.
///
/// Works on the surroundings of the folded tets only: the vertices within a few rings move, the
/// others stay, and the map of these tets is made as conformal as possible under a barrier against
/// inversion that is regularised until all of them are on its right side (Garanzha et al. 2021).
/// The surroundings grow while that fails. If even the whole mesh cannot be unfolded, the
/// deformation is blended with the rest shape, which has no foldovers, until none are left; this is
/// reported as the warning "deformation.blended". Vertices on the plate keep their z, unless a tet
/// lies on the plate with all four corners.
FoldoverReport repair_foldovers(const TetMesh& rest, const std::vector<char>& vertex_on_plate,
                                Points& deformed, Context& ctx);

}  // namespace s3
