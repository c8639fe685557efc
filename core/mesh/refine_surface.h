// Coarse CAD triangles become small even ones, so that the size of tets follows a target and not
// the input (Sec. 2).
#pragma once
#include "mesh/tri_mesh.h"

namespace s3 {

/// Splits edges at their middles, longest first, until none is longer than 4/3 of the target, and
/// makes triangles Delaunay within flat regions. The surface as a set of points stays the same
/// (flat: to 1e-7 of its size); the input's vertices stay, with their numbers; new ones follow. A
/// closed manifold stays one. O(n log n) in the size of the result.
/// @param target_edge  mm, > 0
/// @throws Error "mesh.non_manifold" when an edge has more than two triangles, or two that run the
/// same way;
///         "mesh.too_fine" when the result would have more than about 20 million triangles
TriMesh refine_surface(const TriMesh& mesh, double target_edge);

/// The edge length, mm, of even tets that fill the enclosed volume with about `target_tets`: a
/// regular tet has edge³/(6√2).
/// @throws Error "mesh.inverted" when the volume is not positive
double target_edge_for(const TriMesh& mesh, int target_tets);

}  // namespace s3
