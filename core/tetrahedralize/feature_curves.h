// Sharp edges and corners of a surface.
#pragma once
#include <vector>

#include "mesh/aabb_tree.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// Edges where two triangles meet at an angle, and the vertices where such edges end or turn.
struct FeatureCurves {
  std::vector<Vec3> corners;  // mm
  AabbTree segments;          // the sharp edges, as triangles without area; may be empty
};

/// Normals of triangles at a sharp edge differ by more than the angle of this cosine.
inline constexpr double kSharpCosine = 0.8253356149096783;  // 34°

/// @param mesh  any triangles; only edges of exactly two triangles that run along it in opposite
///              directions count
FeatureCurves feature_curves(const TriMesh& mesh);

}  // namespace s3
