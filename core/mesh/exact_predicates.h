// Signs of determinants, exact for all double coordinates short of overflow and underflow (about
// 1e-90 … 1e90).
#pragma once
#include <array>

#include "base/types.h"

namespace s3 {

/// Sign of det(a − d, b − d, c − d): +1 when d lies behind the plane through a, b, c (its normal is
/// (b − a)×(c − a)), −1 when it lies before it, 0 when the four are exactly coplanar.
int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Sign of the signed area of a, b, c seen along axis `drop`: in the coordinates (drop+1, drop+2)
/// mod 3, so that the sign is that of component `drop` of (b − a)×(c − a).
int orient2d(const Vec3& a, const Vec3& b, const Vec3& c, int drop);

using Corners = std::array<Vec3, 3>;

/// True when the corners lie exactly on one line.
bool is_degenerate(const Corners& triangle);
/// True when the closed segment meets the closed triangle; touching and coplanar overlap count.
/// @param triangle  not degenerate
bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Corners& triangle);
/// True when two closed triangles without common corners meet.
bool triangles_meet(const Corners& s, const Corners& t);
/// True when triangles with the common corner s[0] = t[0] meet elsewhere too.
bool triangles_meet_beyond_corner(const Corners& s, const Corners& t);
/// True when triangles with the common edge s[0] s[1] = t[0] t[1] overlap beyond it: coplanar and
/// on one side.
bool triangles_fold_over_edge(const Corners& s, const Corners& t);

}  // namespace s3
