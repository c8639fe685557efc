// Larger tets inside, where a fine boundary does not need small ones.
#pragma once
#include "base/context.h"
#include "mesh/tet_mesh.h"

namespace s3 {

/// Contracts edges from vertices off the boundary, far from it first, until about the wanted number
/// of tets is left, or no more vertex can go. The boundary stays, new tets have dihedral angles of
/// 15° or more, and edges grow slowly with the distance from the boundary. Near-linear time.
/// @throws Cancelled
void coarsen_interior(TetMesh& mesh, Index target_tets, const Context& ctx);

}  // namespace s3
