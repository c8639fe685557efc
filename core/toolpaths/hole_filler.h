// Short beads in the holes that other paths leave.
#pragma once
#include <vector>

#include "toolpaths/medial_axis.h"
#include "toolpaths/path_order.h"

namespace s3 {

/// Short beads in the holes that rings and axis beads leave: at triangular meeting points, and
/// around single maxima.
/// @param coordinate  #V: u of the bead rings
void fill_holes(const WorkLayer& layer, const Values& coordinate, const MedialAxis& axis,
                double width, std::vector<PlannedPath>& paths);

}  // namespace s3
