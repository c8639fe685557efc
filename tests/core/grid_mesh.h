// Tet meshes of boxes for tests: a regular grid, six tets a cell, optionally bent by a function of
// the position.
#pragma once
#include <functional>

#include "mesh/tet_mesh.h"

namespace s3::test {

/// nx×ny×nz cells over [0, size], conforming (Kuhn) subdivision.
/// @param bend  applied to every vertex; empty for none
inline TetMesh make_grid(int nx, int ny, int nz, const Vec3& size,
                         const std::function<Vec3(const Vec3&)>& bend = {}) {
  const auto id = [&](int i, int j, int k) {
    return static_cast<Index>((k * (ny + 1) + j) * (nx + 1) + i);
  };
  Points vertices(static_cast<Eigen::Index>((nx + 1) * (ny + 1) * (nz + 1)), 3);
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) {
        const Vec3 p(size.x() * i / nx, size.y() * j / ny, size.z() * k / nz);
        vertices.row(id(i, j, k)) = bend ? bend(p) : p;
      }
  Tets tets(static_cast<Eigen::Index>(6 * nx * ny * nz), 4);
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  Eigen::Index t = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (const auto& order : kOrders) {
          int c[3] = {i, j, k};
          tets(t, 0) = id(c[0], c[1], c[2]);
          for (int s = 0; s < 3; ++s) {
            ++c[order[s]];
            tets(t, s + 1) = id(c[0], c[1], c[2]);
          }
          ++t;
        }
  return make_tet_mesh(vertices, tets);
}

}  // namespace s3::test
