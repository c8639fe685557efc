// Tets for any triangles: isosurface stuffing of the winding number (Labelle and Shewchuk 2007).
#pragma once
#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// Fills the points of winding number over 1/2 with about `target_tets` tets, of one size along the
/// surface and larger ones inside.
///
/// The boundary follows the surface within a fraction of a tet's edge, sharp edges included where
/// the shape of the tets allows; it is a closed manifold without self-intersections. Walls and gaps
/// thinner than a tet's edge may be lost: a volume that is off is warned about
/// ("tetrahedralize.unresolved").
/// @param surface  finite, indices in range, facing outward where it faces anywhere, mm
/// @return vertices and tets along a Morton curve, with topology
/// @throws Error "tetrahedralize.empty" if nothing has a winding number over 1/2
/// @throws Cancelled
TetMesh fill_by_stuffing(const TriMesh& surface, int target_tets, Context& ctx);

}  // namespace s3
