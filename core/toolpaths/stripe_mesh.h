// The part of a layer inside the walls, where lines along the stress are laid.
#pragma once
#include <array>
#include <vector>

#include "toolpaths/medial_axis.h"

namespace s3 {

/// A submesh of WorkLayer::even with what fields on it need.
struct StripeMesh {
  Points vertices;    // #V×3 mm
  Directions normal;  // #V×3 unit
  Triangles triangles;
  std::vector<Index> work_vertex;  // #V: the vertex of WorkLayer::mesh
  std::vector<Index> origin;       // #F: the triangle of the given layer
  EdgeTable edges;
  Values edge_weight;  // #E: cotangent weights, kept positive
  Values vertex_area;  // #V mm²
};

/// @param keep  #F flags of layer.even.triangles
StripeMesh make_stripe_mesh(const WorkLayer& layer, const std::vector<char>& keep);

}  // namespace s3
