// Lines moved across until their distances are alike.
#pragma once
#include <vector>

#include "toolpaths/path_order.h"

namespace s3 {

/// Moves every line towards the middle between the strands beside it, a few times over, so that
/// what a gap beside a wall or before the end of a line is too wide or too narrow is shared with
/// the lines next to it. At most 0.4 beads, along the layer: normals and thickness move with the
/// points. What already lies stays. A gap that is wider or narrower than a bead by more than 0.7 is
/// left to itself: shared, it would spoil its neighbours without becoming even. What a line's gaps
/// then differ from w, its bead does too, by at most 15 %.
/// @param fixed  what is laid already: walls, fillings
/// @param width  w, mm
/// @param lines  of each area, changed in place
void even_out(const std::vector<PlannedPath>& fixed, double width,
              std::vector<std::vector<Path>>& lines);

}  // namespace s3
