// Morton (Z-curve) order of points: neighbours in space become neighbours in memory.
#pragma once
#include <vector>

#include "base/types.h"

namespace s3 {

/// The order that sorts points along a Z-curve through their bounding box (21 bits an axis); equal
/// codes keep their order.
/// @return #V: new → old
std::vector<Index> morton_order(const Points& points);

}  // namespace s3
