// Toolpaths on curved layers (Sec. 5.1): polylines on the layer surfaces, before resampling.
#pragma once
#include <cstdint>
#include <vector>

#include "base/types.h"

namespace s3 {

enum class PathKind : std::uint8_t { wall, infill, gap_fill };

/// "wall", "infill", "gap_fill": the text form in waypoints.csv and G-code comments.
const char* path_kind_name(PathKind kind);

struct Path {
  Points points;  // #P×3 mm on the layer's surface; a closed path does not repeat its first point
  Directions normals;  // #P×3 unit, from the layer
  Values thickness;    // #P mm: distance to the material below
  Values width;        // #P mm: bead width
  bool closed = false;
  PathKind kind = PathKind::wall;
};

/// The paths of one layer component in print order, with what was measured on it.
struct LayerPaths {
  Index component = 0;  // position in LayerStack::layers
  std::vector<Path> paths;
  double area = 0;          // mm² of the layer's surface
  double covered_area = 0;  // mm² within half a bead width of a path
  double overlap_area = 0;  // mm² laid more than once, where the layer is wider than two beads
  double wide_area = 0;     // mm² of the part that is wider than two beads
  double unfilled_thin_area = 0;  // mm² too thin for one bead, nothing printed there
};

struct Toolpaths {
  std::vector<LayerPaths> layers;  // one for each component, in print order
};

}  // namespace s3
