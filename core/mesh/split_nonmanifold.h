// Which triangles continue each other across an edge, when there are more than two.
#pragma once
#include <vector>

#include "mesh/surface_edges.h"
#include "mesh/tri_mesh.h"
#include "mesh/validate.h"

namespace s3 {

/// Pairs the sides of every edge. Around an edge with more than two triangles, pairs are those that
/// have solid between them: bodies that touch along the edge are taken apart.
/// @param sides  sorted_sides(mesh)
/// @return #sides: the other of the pair, −1 where there is none: the surface is open there
std::vector<Index> paired_sides(const TriMesh& mesh, const std::vector<Side>& sides);

/// Doubles vertices so that every edge has the two triangles of one pair, and every vertex one fan.
/// The doubles stay where they are: bodies that touched still touch.
/// @return the places of the new vertices
Defect split_nonmanifold(TriMesh& mesh);

/// inspect_surface() of a split surface: where doubled vertices and edges only touch each other,
/// that is no intersection.
MeshReport inspect_split(const TriMesh& mesh, const Context* ctx);

}  // namespace s3
