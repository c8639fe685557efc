// Single beads along the medial axis, where an odd number of beads fits across the layer.
#pragma once
#include <vector>

#include "toolpaths/medial_axis.h"
#include "toolpaths/path_order.h"

namespace s3 {

/// Beads along the central pieces of the axis, as wide as what the rings on both sides leave.
std::vector<PlannedPath> axis_beads(const MedialAxis& axis, double width);

/// Removes small rings that lie on a single bead: where the axis runs into a corner, both would
/// fill the same place.
void drop_rings_on_beads(std::vector<PlannedPath>& rings, const std::vector<PlannedPath>& beads,
                         double width);

}  // namespace s3
