// Points spread evenly over a surface.
#pragma once
#include <vector>

#include "base/types.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// About `count` points: each triangle gets its share of the area, placed by a low-discrepancy
/// sequence. No random numbers, so that every print of a model is measured at the same places.
/// @param triangles  if not null, receives the triangle of each point
Points sample_surface(const TriMesh& surface, double count,
                      std::vector<Index>* triangles = nullptr);

}  // namespace s3
