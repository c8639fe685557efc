// Where a body comes to rest when it is put on a table: its facets of the convex hull below the
// centre of mass.
#pragma once
#include <optional>

#include "base/types.h"

namespace s3 {

/// Rolls a rigid body over the corners and edges of its convex hull until its centre of mass stands
/// above the hull of the points that touch the table. O(#V) a roll.
/// @param vertices  #V×3, not empty
/// @param up        unit vector: the body's direction that points up at first
/// @return the direction that points up at rest; nothing when the body balances on a point, or
/// rolls for long, as a ball does
std::optional<Vec3> resting_pose(const Points& vertices, const Vec3& center_of_mass, Vec3 up);

}  // namespace s3
