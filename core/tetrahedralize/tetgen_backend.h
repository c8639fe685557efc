// The mesher TetGen behind one function. Include tetrahedralize.h instead, unless you are it.
#pragma once
#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// A mesh that keeps all triangles of its surface has at least about this many tets for each.
inline constexpr double kTetsPerTriangle = 2.4;

/// False in a build without TetGen.
bool has_tetgen();

/// Fills a closed surface with about `target_tets` tets; the surface keeps its form, its triangles
/// may be split.
/// @param surface  closed, manifold, oriented, without self-intersections (mesh/validate.h), mm
/// @throws Error "tetrahedralize.failed" if the surface intersects or nearly touches itself,
///         "tetrahedralize.empty" if it encloses nothing, "tetrahedralize.unavailable" in a build
///         without TetGen
/// @throws Cancelled
TetMesh fill_with_tetgen(const TriMesh& surface, int target_tets, Context& ctx);

}  // namespace s3
