// Setup orientation: which side of a model should point up (Sec. 5.4.4), with the figures that
// tell.
#pragma once
#include <string>
#include <vector>

#include "base/context.h"
#include "base/types.h"

namespace s3 {

/// One way to stand on the plate. Figures hold for planar layers.
struct Orientation {
  Vec3 up = Vec3::UnitZ();  // the model's direction that points up
  std::string rotate;       // input.rotate that stands it so: Euler degrees "x,y,0"
  /// Faces that overhang by more than 45° (n_z < −sin 45°), without those on the plate (all corners
  /// within 1 % of the height above it, n_z < −0.9), mm².
  double overhang_area = 0;
  /// Space below these faces, straight down to the model or the plate, mm³. By rays from points
  /// spread evenly over the surface.
  double support_volume = 0;
  /// Faces within 0.1 % of the height above the plate with n_z < −0.9, seen from below, mm².
  double contact_area = 0;
  double height = 0;  // mm
  /// Turned by this angle the model falls over; 0 when it does so by itself. What lies within 1 %
  /// of the height above the plate carries it.
  double tipping_deg = 0;
  bool stable = false;  // tipping_deg reaches 12°: a column is less than 4.7 times as high as wide
};

enum class OrientationGoal {
  least_support,  // the least cost (see rank_orientations)
  flat_face       // the largest contact with the plate
};

/// The best ways to stand, best first; any two differ by at least 10° in what points up.
///
/// Candidates are up as it is, the large flat regions laid on the plate, the poses in which the
/// model comes to rest, its axes, an even covering of the sphere, and steps around the best.
///
/// least_support: the cost is overhang area / surface area + 0.2 · support volume / model volume
/// (support is printed sparse, so 0.2 of its space is material), and two terms for what stands
/// badly: 1 − tipping angle / 12° and 1 − contact / 2 % of the model's shadow, where positive. Of
/// candidates within 0.01 of the least cost the one with the largest contact goes first, then the
/// lowest, then the first in the order above.
///
/// flat_face: only candidates that touch the plate with a face; stable ones before others, then the
/// largest contact; within 2 % of it the least cost.
///
/// Deterministic. About 300 candidates, each in linear time with a small constant: the support
/// volume comes from 4096 points (the last comparison: 32768).
/// @param vertices   #V×3, mm, not empty
/// @param triangles  #F×3, counter-clockwise from outside; need not be closed (the centre of mass
/// is then the surface's)
/// @param count      at most this many results
/// @param ctx        may be null; asked for a cancel on the way
/// @return for flat_face possibly empty; otherwise at least one
std::vector<Orientation> rank_orientations(const Points& vertices, const Triangles& triangles,
                                           OrientationGoal goal, std::size_t count = 5,
                                           const Context* ctx = nullptr);

/// The figures of one orientation, as precise as rank_orientations() gives them.
Orientation measure_orientation(const Points& vertices, const Triangles& triangles, const Vec3& up);

/// Euler degrees "x,y,0" (turns by x, then y, about fixed axes) that bring `up` to z, within 1e-5°.
std::string rotation_text(const Vec3& up);

}  // namespace s3
