// Waypoints in the text form of the paper's own programs: `x y z nx ny nz` a line, one file for
// each layer component, y up with (x, y, z) ↦ (x, z, −y), normals pointing into the part. There is
// no mark between paths: their readers take a step of more than 4 mm for a travel.
#pragma once
#include <string>
#include <vector>

#include "base/context.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// @return one text for each component in print order, to be named 0.txt, 1.txt, …; empty where a
/// component has no path
std::vector<std::string> write_authors_waypoints(const Waypoints& waypoints, Context& ctx);

}  // namespace s3
