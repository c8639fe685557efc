#include "toolpaths/stripe_mesh.h"

#include <algorithm>

namespace s3 {
namespace {

/// Half the cotangents of the angles opposite to each edge. Below a small positive value an edge
/// would repel what it should make alike.
Values cotangent_weights(const StripeMesh& mesh) {
  constexpr double kLeastWeight = 0.05, kMostOfOne = 5;
  Values weight = Values::Zero(static_cast<Eigen::Index>(mesh.edges.ends.size()));
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vec3 corner = mesh.vertices.row(mesh.triangles(f, (k + 2) % 3));
      const Vec3 a = Vec3(mesh.vertices.row(mesh.triangles(f, k))) - corner;
      const Vec3 b = Vec3(mesh.vertices.row(mesh.triangles(f, (k + 1) % 3))) - corner;
      const double sine = a.cross(b).norm(), cosine = a.dot(b);
      const double half_cotangent = sine * 2 * kMostOfOne > std::abs(cosine)
                                        ? 0.5 * cosine / sine
                                        : (cosine > 0 ? kMostOfOne : -kMostOfOne);
      weight(mesh.edges.of_triangle[static_cast<std::size_t>(f)][static_cast<std::size_t>(k)]) +=
          half_cotangent;
    }
  return weight.cwiseMax(kLeastWeight);
}

Values vertex_areas(const StripeMesh& mesh) {
  Values area = Values::Zero(mesh.vertices.rows());
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    const Vec3 a = mesh.vertices.row(mesh.triangles(f, 0));
    const Vec3 b = mesh.vertices.row(mesh.triangles(f, 1));
    const Vec3 c = mesh.vertices.row(mesh.triangles(f, 2));
    for (int k = 0; k < 3; ++k) area(mesh.triangles(f, k)) += (b - a).cross(c - a).norm() / 6;
  }
  return area;
}

}  // namespace

StripeMesh make_stripe_mesh(const WorkLayer& layer, const std::vector<char>& keep) {
  StripeMesh mesh;
  const Triangles& all = layer.even.triangles;
  std::vector<Index> number(static_cast<std::size_t>(layer.even.vertices), -1);
  mesh.triangles.resize(std::count(keep.begin(), keep.end(), 1), 3);
  Eigen::Index row = 0;
  for (std::size_t f = 0; f < keep.size(); ++f) {
    if (!keep[f]) continue;
    for (int k = 0; k < 3; ++k) {
      const Index v = all(static_cast<Eigen::Index>(f), k);
      Index& n = number[static_cast<std::size_t>(v)];
      if (n < 0) {
        n = static_cast<Index>(mesh.work_vertex.size());
        mesh.work_vertex.push_back(v);
      }
      mesh.triangles(row, k) = n;
    }
    mesh.origin.push_back(layer.even.origin[f]);
    ++row;
  }
  mesh.vertices = layer.mesh.vertices(mesh.work_vertex, Eigen::all);
  mesh.normal = layer.mesh.normal(mesh.work_vertex, Eigen::all);
  mesh.edges = make_edges(mesh.triangles, static_cast<Index>(mesh.work_vertex.size()));
  mesh.edge_weight = cotangent_weights(mesh);
  mesh.vertex_area = vertex_areas(mesh);
  return mesh;
}

}  // namespace s3
