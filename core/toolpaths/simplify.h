// Polylines with fewer points.
#pragma once
#include <vector>

#include "base/types.h"
#include "toolpaths/toolpaths.h"

namespace s3 {

/// Marks the points that a polyline needs to stay within `tolerance` (Douglas and Peucker 1973);
/// always both ends.
/// @param points  #P×3, #P ≥ 1
std::vector<char> find_corners(const Points& points, double tolerance);

/// The same for a path, by its place and by its width: between the marked points, both are straight
/// within the tolerance.
/// @return #P, of a closed path #P+1: the last entry stands for the return to the first point
std::vector<char> find_path_corners(const Path& path, double tolerance);

/// Removes points that the path's shape does not need. Tiny rings keep theirs.
void simplify(Path& path, double tolerance);

}  // namespace s3
