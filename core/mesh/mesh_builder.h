// Growing vertex and triangle lists for the readers.
#pragma once
#include <algorithm>
#include <vector>

#include "mesh/tri_mesh.h"

namespace s3 {

/// Collects a surface whose size is not known before its end.
class MeshBuilder {
 public:
  void add_vertex(const Vec3& p) {
    coordinates_.insert(coordinates_.end(), p.data(), p.data() + 3);
  }
  void add_triangle(Index a, Index b, Index c) { corners_.insert(corners_.end(), {a, b, c}); }
  std::size_t vertex_count() const { return coordinates_.size() / 3; }
  std::size_t triangle_count() const { return corners_.size() / 3; }
  /// The largest vertex number in a triangle, −1 without triangles.
  Index largest_corner() const {
    return corners_.empty() ? -1 : *std::max_element(corners_.begin(), corners_.end());
  }

  TriMesh take() {
    TriMesh mesh;
    mesh.vertices = Eigen::Map<const Points>(coordinates_.data(), rows(coordinates_), 3);
    std::vector<double>().swap(coordinates_);
    mesh.triangles = Eigen::Map<const Triangles>(corners_.data(), rows(corners_), 3);
    std::vector<Index>().swap(corners_);
    return mesh;
  }

 private:
  template <class T>
  static Eigen::Index rows(const std::vector<T>& flat) {
    return static_cast<Eigen::Index>(flat.size() / 3);
  }

  std::vector<double> coordinates_;
  std::vector<Index> corners_;
};

}  // namespace s3
