// Which path lies inside which, and the order of printing that follows: from outside to inside,
// nearest first.
#pragma once
#include <vector>

#include "toolpaths/medial_axis.h"
#include "toolpaths/toolpaths.h"

namespace s3 {

/// A path with its place in the nesting.
struct PlannedPath {
  Path path;
  Index level = 0;          // how many rings lie outside
  Index inner_vertex = -1;  // a mesh vertex on its inner side
};

/// Paths that lie side by side in one piece of the layer; `children` lie further inside.
struct PathGroup {
  Index level = 0;
  std::vector<Index> paths, children;
};
struct PathTree {
  std::vector<PlannedPath> paths;
  std::vector<PathGroup> groups;
  std::vector<Index> roots;  // groups
};

/// Nests paths by the pieces of {u ≥ level + ½}. Cost O(#V log #V).
/// @param coordinate  #V: u, ascending from the boundary
PathTree nest_paths(const WorkLayer& layer, const Values& coordinate,
                    std::vector<PlannedPath> paths);

/// Depth first from outside to inside; among what may come next, the nearest. Closed paths are
/// turned so that they start at their point nearest to where the one before ended, open ones run
/// from the nearer end.
/// @param start  where the first path should begin, mm
std::vector<Path> order_paths(const PathTree& tree, const Vec3& start);

}  // namespace s3
