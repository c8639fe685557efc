// Rotations: between directions, closest to a matrix, and as quaternions where q and −q are the
// same.
#pragma once
#include "base/types.h"

namespace s3 {

/// The rotation of least angle that takes unit a to unit b. Stable near 0° and near 180°; at
/// exactly 180° the axis is a fixed choice perpendicular to a.
Quat minimal_rotation(const Vec3& a, const Vec3& b);

/// The rotation R (det = +1) that maximises tr(RᵀF), that is, minimises ‖F − R‖_F. Where F is
/// reflecting, singular or zero it is one of the minimisers, and always a rotation.
Mat3 closest_rotation(const Mat3& F);

/// q or −q, whichever is nearer to `reference`: both are the same rotation.
Quat aligned(const Quat& q, const Quat& reference);

/// The normalised mean of (1−s) a and s b, b aligned with a. s in [0, 1].
Quat blend(const Quat& a, const Quat& b, double s);

}  // namespace s3
