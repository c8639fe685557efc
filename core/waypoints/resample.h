// A path as evenly spaced waypoints that keep its corners.
#pragma once
#include "toolpaths/toolpaths.h"

namespace s3 {

/// @param spacing    mm, largest distance along the path between two points
/// @param tolerance  mm, largest distance of the path from the polyline of the result
/// @return an open path; the first point is repeated at the end where `path` is closed. Empty for
/// fewer than two points.
Path resample(const Path& path, double spacing, double tolerance);

}  // namespace s3
