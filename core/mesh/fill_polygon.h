// Triangles for a polygon with holes that lies in a plane, or nearly.
#pragma once
#include <array>
#include <vector>

#include "base/types.h"

namespace s3 {

/// Fills a polygon by clipping its best ears (Meisters 1975); holes are joined with it by bridges.
/// Uses exact signs in the coordinate plane nearest to the polygon's; no triangle is flat, and
/// every vertex of a loop is used. Near-linear time for polygons that are not mazes.
/// @param points  mm
/// @param loops   the outer one first, counter-clockwise seen against `normal`; holes clockwise.
///                Simple, without common vertices
/// @return triangles that face along `normal`; empty when the loops cross themselves or each other
std::vector<std::array<Index, 3>> fill_polygon(const Points& points,
                                               const std::vector<std::vector<Index>>& loops,
                                               const Vec3& normal);

}  // namespace s3
