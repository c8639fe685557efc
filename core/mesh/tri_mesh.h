// A surface: vertices and counter-clockwise triangles.
#pragma once
#include <string>
#include <vector>

#include "base/types.h"

namespace s3 {

struct TriMesh {
  Points vertices;      // #V×3 mm
  Triangles triangles;  // #F×3, counter-clockwise from outside
};

struct Box {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();
  double diagonal() const { return (max - min).norm(); }
};

Box bounding_box(const Points& vertices);
/// Unnormalised normal: twice the area long.
Vec3 triangle_normal_2a(const Points& vertices,
                        const Eigen::Ref<const Eigen::Matrix<Index, 1, 3>>& triangle);
/// #F×3 unit normals; zero for degenerate triangles.
Directions triangle_normals(const TriMesh& mesh);
double surface_area(const TriMesh& mesh);
/// Signed volume of a closed surface, mm³; positive when triangles face outward.
double enclosed_volume(const TriMesh& mesh);

}  // namespace s3
