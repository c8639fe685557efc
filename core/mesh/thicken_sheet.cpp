#include "mesh/thicken_sheet.h"

#include <cmath>
#include <vector>

#include "mesh/repair_sheets.h"
#include "mesh/split_nonmanifold.h"
#include "mesh/surface_edges.h"

namespace s3 {

namespace {

// Each triangle counts by its angle at the vertex, so that the triangulation does not matter.
Directions vertex_normals(const TriMesh& mesh) {
  Directions sum = Directions::Zero(mesh.vertices.rows(), 3);
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    const Vec3 normal = triangle_normal_2a(mesh.vertices, mesh.triangles.row(f)).normalized();
    for (int i = 0; i < 3; ++i) {
      const Vec3 at = vertex_of(mesh, mesh.triangles(f, i));
      const Vec3 a = vertex_of(mesh, mesh.triangles(f, (i + 1) % 3)) - at;
      const Vec3 b = vertex_of(mesh, mesh.triangles(f, (i + 2) % 3)) - at;
      sum.row(mesh.triangles(f, i)) += std::atan2(a.cross(b).norm(), a.dot(b)) * normal;
    }
  }
  return sum.rowwise().normalized();
}

}  // namespace

TriMesh thicken_sheet(TriMesh sheet, double thickness) {
  turn_to_neighbours(sheet);
  split_nonmanifold(sheet);
  const std::vector<Side> sides = sorted_sides(sheet);
  const std::vector<Index> other = paired_sides(sheet, sides);
  const Points shift = 0.5 * thickness * vertex_normals(sheet);
  const auto n = static_cast<Index>(sheet.vertices.rows());
  const Eigen::Index count = sheet.triangles.rows();
  std::vector<Index> rim;  // sides
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (other[i] < 0) rim.push_back(static_cast<Index>(i));

  TriMesh plate;
  plate.vertices.resize(2 * n, 3);
  plate.vertices << sheet.vertices + shift, sheet.vertices - shift;
  plate.triangles.resize(2 * count + 2 * static_cast<Eigen::Index>(rim.size()), 3);
  plate.triangles.topRows(count) = sheet.triangles;
  for (Eigen::Index f = 0; f < count; ++f)
    plate.triangles.row(count + f) << sheet.triangles(f, 0) + n, sheet.triangles(f, 2) + n,
        sheet.triangles(f, 1) + n;
  Eigen::Index next = 2 * count;
  for (const Index i : rim) {
    const Index a = sides[static_cast<std::size_t>(i)].from();
    const Index b = sides[static_cast<std::size_t>(i)].to();
    plate.triangles.row(next++) << b, a, a + n;
    plate.triangles.row(next++) << b, a + n, b + n;
  }
  return plate;
}

}  // namespace s3
