// Points spread evenly over a surface, each with its triangle.
#pragma once
#include <vector>

#include "mesh/tri_mesh.h"

namespace s3 {

struct SurfacePoint {
  Vec3 point;
  Index face;
};

/// Steps of equal area along the faces in their order; within a face, Hammersley's points. Each
/// stands for the same area. No random numbers.
/// @return `count` points, fewer by rounding at the end; none for a surface without area, or one
/// beyond numbers
std::vector<SurfacePoint> spread_points(const TriMesh& mesh, std::size_t count);

}  // namespace s3
