// Closed surfaces with known volumes.
#pragma once
#include <cmath>
#include <utility>
#include <vector>

#include "base/units.h"
#include "mesh/tri_mesh.h"

namespace s3::test {

inline TriMesh join(const TriMesh& a, const TriMesh& b) {
  TriMesh both{Points(a.vertices.rows() + b.vertices.rows(), 3),
               Triangles(a.triangles.rows() + b.triangles.rows(), 3)};
  both.vertices << a.vertices, b.vertices;
  both.triangles << a.triangles,
      (b.triangles.array() + static_cast<Index>(a.vertices.rows())).matrix();
  return both;
}

inline TriMesh moved(TriMesh mesh, const Vec3& by) {
  mesh.vertices.rowwise() += by.transpose();
  return mesh;
}

inline TriMesh inverted(TriMesh mesh) {
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

// The surface of the box [0, size]³ with twelve triangles.
inline TriMesh cube(double size) {
  TriMesh mesh{Points(8, 3), Triangles(12, 3)};
  for (int v = 0; v < 8; ++v)
    mesh.vertices.row(v) << size * (v & 1), size * (v >> 1 & 1), size * (v >> 2);
  mesh.triangles << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6,
      0, 6, 2, 1, 3, 7, 1, 7, 5;
  for (Eigen::Index f = 4; f < 12; ++f)
    if (const Vec3 n = triangle_normal_2a(mesh.vertices, mesh.triangles.row(f));
        n.dot(Vec3(mesh.vertices.row(mesh.triangles(f, 0))) - Vec3::Constant(0.5 * size)) < 0)
      std::swap(mesh.triangles(f, 1), mesh.triangles(f, 2));
  return mesh;
}

// A closed grid of n×m quads around two angles: a torus.
inline TriMesh torus(double ring_radius, double tube_radius, int n, int m) {
  TriMesh mesh{Points(n * m, 3), Triangles(2 * n * m, 3)};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const double u = 2 * kPi * i / n, v = 2 * kPi * j / m,
                   r = ring_radius + tube_radius * std::cos(v);
      const int a = i * m + j, b = (i + 1) % n * m + j, c = (i + 1) % n * m + (j + 1) % m,
                d = i * m + (j + 1) % m;
      mesh.vertices.row(a) << r * std::cos(u), r * std::sin(u), tube_radius * std::sin(v);
      mesh.triangles.row(2 * a) << a, b, c;
      mesh.triangles.row(2 * a + 1) << a, c, d;
    }
  return mesh;
}

// A cube's faces as n×n grids, pushed out to a sphere.
inline TriMesh sphere(double radius, int n) {
  TriMesh mesh{Points(6 * n * n + 2, 3), Triangles(12 * n * n, 3)};
  std::vector<Index> index(static_cast<std::size_t>((n + 1) * (n + 1) * (n + 1)), -1);
  Index vertices = 0, triangles = 0;
  const auto vertex = [&](const Eigen::Vector3i& c) {
    Index& known = index[static_cast<std::size_t>((c.z() * (n + 1) + c.y()) * (n + 1) + c.x())];
    if (known < 0) {
      known = vertices++;
      const Vec3 tangent = ((2.0 * c.cast<double>() / n - Vec3::Ones()).array() * (kPi / 4)).tan();
      mesh.vertices.row(known) = radius * tangent.normalized().transpose();
    }
    return known;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int di, int dj) {
            Eigen::Vector3i c;
            c[axis] = side * n;
            c[(axis + 1) % 3] = i + di;
            c[(axis + 2) % 3] = j + dj;
            return vertex(c);
          };
          const Index a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
          mesh.triangles.row(triangles++) << a, side ? b : c, side ? c : b;
          mesh.triangles.row(triangles++) << a, side ? c : d, side ? d : c;
        }
  return mesh;
}

}  // namespace s3::test
