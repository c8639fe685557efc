// Where the boundary of a tet mesh is no manifold.
#pragma once
#include <vector>

#include "mesh/tet_mesh.h"

namespace s3 {

/// Vertices on boundary edges with other than two boundary faces, and vertices with more than one
/// fan of boundary faces; sorted. O(n log n) in boundary faces.
std::vector<Index> nonmanifold_boundary_vertices(const TetMesh& mesh);

}  // namespace s3
