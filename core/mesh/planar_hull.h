// Convex hulls in the plane, and how far inside one a point lies.
#pragma once
#include <vector>

#include <Eigen/Core>

namespace s3 {

using Vec2 = Eigen::Vector2d;

/// Corners of the convex hull, counter-clockwise, without points on its edges. One or two corners
/// where the points coincide or lie on a line; none for none. O(n log n).
std::vector<Vec2> convex_hull(std::vector<Vec2> points);

struct HullBorder {
  double inside = 0;            // distance to the border, positive inside the hull
  Vec2 nearest = Vec2::Zero();  // on the border
};

/// @param hull  from convex_hull(), not empty; a point or a segment is all border
HullBorder nearest_border(const std::vector<Vec2>& hull, const Vec2& point);

}  // namespace s3
