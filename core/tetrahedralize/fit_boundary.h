// The boundary of a stuffed lattice onto the surface: sharp edges, corners, and good tets.
#pragma once
#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "tetrahedralize/feature_curves.h"
#include "tetrahedralize/lattice_cuts.h"

namespace s3 {

/// Moves vertices so that boundary edges run along the sharp edges of the surface, and so that the
/// worst dihedral angles get better. Boundary vertices stay on flat parts of the surface, and
/// beside curved ones by half of what the faces cut off, so that the volume is right; no tet is
/// turned over or made worse than about 8° (or than it was). Connectivity stays.
/// @param mesh  a boundary that does not intersect itself; it will not afterwards: vertices where
/// it
///              would keep their place
/// @param size  mm, the lattice's edge: the scale of what may move
void fit_boundary(TetMesh& mesh, const SurfaceSolid& solid, const FeatureCurves& curves,
                  double size, Context& ctx);

}  // namespace s3
