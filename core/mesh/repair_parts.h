// Repair of a file with several parts: each by itself, so that parts that touch, overlap or lie
// inside each other stay what they are.
#pragma once
#include <vector>

#include "mesh/repair.h"

namespace s3 {

/// Repairs every part that is closed by itself on its own; the others, such as the groups of one
/// surface, are repaired as one. What overlaps afterwards, or lies inside another, is left to a
/// mesher that follows the winding number, which joins it.
/// @param part_of_triangle  #F: numbers from 0; all 0 is repair_surface()
/// @throws Error as repair_surface() when no part is left
RepairResult repair_parts(const TriMesh& surface, const std::vector<Index>& part_of_triangle,
                          Context& ctx);

}  // namespace s3
