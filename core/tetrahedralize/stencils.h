// Lattice and cuts to tets: the warp and the stencils of isosurface stuffing.
#pragma once
#include <vector>

#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "tetrahedralize/bcc_lattice.h"
#include "tetrahedralize/lattice_cuts.h"

namespace s3 {

/// The part of a lattice inside a solid as tets with a manifold boundary.
///
/// Lattice vertices with a cut nearby are moved onto it, so that no tet gets short edges; the
/// lattice's tets across the border are replaced by their part inside. With cuts on the border, all
/// dihedral angles are between about 10° and 165°. Where moved vertices would make the boundary
/// touch itself in a vertex or an edge, they stay in their place and the border runs a little
/// beside its cuts instead.
/// @param winding  by winding_at_vertices()
/// @param cuts  of the lattice's edges, by lattice_cuts()
/// @return with topology, not reordered; the boundary is a closed manifold without
///         self-intersections. Empty when nothing is inside.
TetMesh stuff_lattice(const BccLattice& lattice, const std::vector<signed char>& winding,
                      const std::vector<LatticeCut>& cuts, Context& ctx);

}  // namespace s3
