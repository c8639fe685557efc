// Tet meshes for tests that are made of the cells of a grid: overhangs, hooks, bridges.
#pragma once
#include <functional>
#include <vector>

#include "grid_mesh.h"

namespace s3::test {

/// The tets of make_grid() whose centroid is kept. Vertices that no tet uses are removed.
inline TetMesh make_carved(int nx, int ny, int nz, const Vec3& size,
                           const std::function<bool(const Vec3&)>& keep) {
  const TetMesh grid = make_grid(nx, ny, nz, size);
  std::vector<Index> number(static_cast<std::size_t>(grid.vertex_count()), -1);
  std::vector<Index> kept;
  for (Index t = 0; t < grid.tet_count(); ++t)
    if (keep(grid.centroid(t))) kept.push_back(t);
  for (const Index t : kept)
    for (int i = 0; i < 4; ++i) number[grid.tets(t, i)] = 0;
  Points vertices(grid.vertices.rows(), 3);
  Index used = 0;
  for (Index v = 0; v < grid.vertex_count(); ++v) {
    if (number[v] < 0) continue;
    vertices.row(used) = grid.vertices.row(v);
    number[v] = used++;
  }
  Tets tets(static_cast<Eigen::Index>(kept.size()), 4);
  for (std::size_t k = 0; k < kept.size(); ++k)
    for (int i = 0; i < 4; ++i)
      tets(static_cast<Eigen::Index>(k), i) = number[grid.tets(kept[k], i)];
  return make_tet_mesh(vertices.topRows(used), tets);
}

/// A table: a square leg under a wider top, 5 mm of overhang all around. One cell is 1 mm.
inline TetMesh make_table() {
  return make_carved(16, 16, 14, Vec3(16, 16, 14), [](const Vec3& p) {
    return p.z() > 10 || (p.x() > 5 && p.x() < 11 && p.y() > 5 && p.y() < 11);
  });
}

}  // namespace s3::test
