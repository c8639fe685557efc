// Renumbering of a tet mesh along a space-filling curve: solver and field loops then walk memory.
#pragma once
#include <vector>

#include "mesh/tet_mesh.h"

namespace s3 {

/// The same mesh with vertices, and tets by centroid, in Morton order.
/// @param vertex_order, tet_order  if not null, receive new → old (file data follows its tets with
/// it)
TetMesh reorder_along_morton(const TetMesh& mesh, std::vector<Index>* vertex_order = nullptr,
                             std::vector<Index>* tet_order = nullptr);

}  // namespace s3
