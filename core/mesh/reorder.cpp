#include "mesh/reorder.h"

#include <utility>

#include "math/morton.h"

namespace s3 {

TetMesh reorder_along_morton(const TetMesh& mesh, std::vector<Index>* vertex_order,
                             std::vector<Index>* tet_order) {
  std::vector<Index> old_vertex = morton_order(mesh.vertices);
  std::vector<Index> new_vertex(old_vertex.size());
  Points vertices(mesh.vertices.rows(), 3);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    vertices.row(v) = mesh.vertices.row(old_vertex[static_cast<std::size_t>(v)]);
    new_vertex[static_cast<std::size_t>(old_vertex[static_cast<std::size_t>(v)])] = v;
  }

  Points centroids(mesh.tets.rows(), 3);
  for (Index t = 0; t < mesh.tet_count(); ++t) centroids.row(t) = mesh.centroid(t);
  std::vector<Index> old_tet = morton_order(centroids);
  Tets tets(mesh.tets.rows(), 4);
  for (Index t = 0; t < mesh.tet_count(); ++t)
    for (int i = 0; i < 4; ++i)
      tets(t, i) =
          new_vertex[static_cast<std::size_t>(mesh.tets(old_tet[static_cast<std::size_t>(t)], i))];

  if (vertex_order) *vertex_order = std::move(old_vertex);
  if (tet_order) *tet_order = std::move(old_tet);
  return make_tet_mesh(std::move(vertices), std::move(tets));
}

}  // namespace s3
