#include "mesh/tri_mesh.h"

namespace s3 {

Box bounding_box(const Points& vertices) {
  Box box;
  if (vertices.rows() == 0) return box;
  box.min = vertices.colwise().minCoeff();
  box.max = vertices.colwise().maxCoeff();
  return box;
}

Vec3 triangle_normal_2a(const Points& vertices,
                        const Eigen::Ref<const Eigen::Matrix<Index, 1, 3>>& triangle) {
  const Vec3 a = vertices.row(triangle(0)), b = vertices.row(triangle(1)),
             c = vertices.row(triangle(2));
  return (b - a).cross(c - a);
}

Directions triangle_normals(const TriMesh& mesh) {
  Directions normals(mesh.triangles.rows(), 3);
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    const Vec3 n = triangle_normal_2a(mesh.vertices, mesh.triangles.row(f));
    const double length = n.norm();
    normals.row(f) = length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
  }
  return normals;
}

double surface_area(const TriMesh& mesh) {
  double area = 0;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    area += 0.5 * triangle_normal_2a(mesh.vertices, mesh.triangles.row(f)).norm();
  return area;
}

double enclosed_volume(const TriMesh& mesh) {
  double six_volume = 0;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    const Vec3 a = mesh.vertices.row(mesh.triangles(f, 0)),
               b = mesh.vertices.row(mesh.triangles(f, 1)),
               c = mesh.vertices.row(mesh.triangles(f, 2));
    six_volume += a.dot(b.cross(c));
  }
  return six_volume / 6.0;
}

}  // namespace s3
