// The bead coordinate of contour-parallel toolpaths (Sec. 5.1), and the rings that are its
// iso-curves.
#pragma once
#include <vector>

#include "toolpaths/medial_axis.h"
#include "toolpaths/path_order.h"

namespace s3 {

/// The bead coordinate and the width of the innermost ring at the vertices.
struct BeadField {
  double width;                   // mm, w
  Values coordinate;              // #V: u
  std::vector<Index> inner_ring;  // #V: the ring that takes up the difference; −1 for none
  Values shift;                   // #V mm: how far that ring stands inside of its plain place

  double shift_of(Index vertex, Index ring) const {
    return inner_ring[static_cast<std::size_t>(vertex)] == ring ? shift(vertex) : 0;
  }
  /// Distance of a ring from the boundary, and its width, as seen from a vertex.
  double place_of(Index vertex, Index ring) const {
    return (ring + 0.5) * width + shift_of(vertex, ring);
  }
  double width_of(Index vertex, Index ring) const { return width + 2 * shift_of(vertex, ring); }
};

/// u = d/w away from the medial axis, and stretched or squeezed for the innermost bead so that the
/// beads fill the width exactly.
BeadField make_bead_field(const WorkLayer& layer, const MedialPlan& medial, double width);

/// The curves u = ½, 3/2, …: closed rings, each with a mesh vertex on its inner side.
std::vector<PlannedPath> trace_rings(const WorkLayer& layer, const BeadField& field);

}  // namespace s3
