// Lines that end side by side at a wall become one path with a turn along the wall.
#pragma once
#include <vector>

#include "toolpaths/toolpaths.h"

namespace s3 {

/// Joins open paths through pieces of closed fences: an end lies on a fence when it is nearer than
/// half a bead. Two ends are joined when no other end lies between them on the fence and they are
/// at most three beads apart. Lines at the rim of a bundle come first, so that bundles become one
/// path.
/// @param fences  closed paths along the walls, at half a bead's distance from them
/// @return the joined paths; those without a partner unchanged
std::vector<Path> join_stripes(const std::vector<Path>& lines, const std::vector<Path>& fences,
                               double width);

}  // namespace s3
