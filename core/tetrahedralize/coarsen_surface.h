// Needles, caps and too many triangles out of a closed surface, within a tolerance.
#pragma once
#include "base/context.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// Contracts short edges and flips edges of flat triangles, shortest first, where the surface stays
/// within the tolerance of the given one, and the given one within the tolerance of it (measured at
/// its vertices, middles of edges and of triangles). Vertices keep their places: those that are
/// left are vertices of the given mesh, in their order. Vertices of sharp edges go along them, and
/// corners stay, unless an edge is so short that no tet of the wanted size could use it. A closed
/// manifold stays one; that it does not cross itself is to be checked afterwards. Near-linear time.
/// @param surface  closed, manifold, oriented, mm
/// @param edge  mm: the wanted length; edges of less than about two thirds are contracted
/// @param tolerance  mm
/// @throws Cancelled
TriMesh coarsen_surface(const TriMesh& surface, double edge, double tolerance, const Context& ctx);

}  // namespace s3
