// TetGen with a surface that lets it make usable tets.
#pragma once
#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "mesh/tri_mesh.h"

namespace s3 {

struct SolidFilling {
  TetMesh mesh;             // vertices and tets along a Morton curve, with topology
  bool simplified = false;  // the boundary does not keep the surface exactly
};

/// Fills the border of a solid by TetGen: its triangles split to the size of the tets, else as they
/// are.
///
/// Narrow triangles force flat tets, and fine ones more tets than wanted. Where the smallest
/// dihedral angle is under 1°, or there would be half as many tets again, the surface is
/// simplified (coarsen_surface.h) within 1, 2.5, then 5 % of a tet's edge, and the best mesh is
/// taken, with a warning "tetrahedralize.simplified". Warns ("tetrahedralize.more_tets") about a
/// surface whose details force more tets still.
/// @param surface  closed, manifold, oriented, without self-intersections (mesh/validate.h), mm
/// @throws Error as fill_with_tetgen()
/// @throws Cancelled
SolidFilling fill_solid(const TriMesh& surface, int target_tets, Context& ctx);

}  // namespace s3
