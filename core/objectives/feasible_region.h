// The directions that satisfy every objective of one tet, and the closest of them (Sec. 3.1, Eq.
// 7).
#pragma once
#include <array>

#include "base/types.h"
#include "objectives/objectives.h"

namespace s3 {

/// The bounds of H_SF, H_SR and H_SQ and the weights of the objectives; the same for all tets.
struct RegionBounds {
  double sin_alpha, sin_beta, sin_gamma;
  double support_free, strength, surface_quality;  // weights; 0 switches the objective off
};

/// @param alpha_margin  rad: H_SF is made smaller by it, so that a target on its border is not
/// violated again at once
RegionBounds region_bounds(const ObjectiveParams& params, double alpha_margin = 0);

/// Sine of the least angle at which layers that must rise do so.
inline constexpr double kLeastRise = 0.1;

/// H_e of Eq. 7: the intersection over all boundary faces of the tet, and over S; with what the
/// machine and the support of islands ask for.
struct FeasibleRegion {
  struct Face {
    Vec3 normal;
    bool quality;  // H_SQ holds here too
  };
  RegionBounds bounds;
  std::array<Face, 4> faces;  // the faces that are not on the plate
  int face_count = 0;
  bool critical = false;  // in S
  Vec3 tau = Vec3::Zero();
  bool on_plate = false;   // it has a face on the plate: it prefers d = z
  double cos_tilt = -1;    // the machine reaches d with d·z ≥ cos_tilt; −1 reaches everything
  bool must_rise = false;  // layers must rise along `rise` (unit vector): d·rise ≥ kLeastRise
  Vec3 rise = Vec3::Zero();

  /// Something is asked of this tet (Π and w_k look at these only).
  bool constrained() const { return face_count > 0 || critical; }
};

/// @param t  any tet; one inside the solid and outside S has a region without bounds
FeasibleRegion feasible_region(const ObjectiveField& objectives, const RegionBounds& bounds,
                               Index t);

/// Sum of weight × angle (rad) by which the unit vector `d` misses each bound of the region; 0
/// inside.
double region_violation(const FeasibleRegion& region, const Vec3& d);

struct Projection {
  Vec3 direction;        // unit vector
  double distance;       // rad, from d
  bool feasible = true;  // false: no direction satisfies all bounds
};

/// Closest direction to the unit vector `d` inside the region, in geodesic distance.
///
/// The region is bounded by circles, so the closest point is one of: d, its closest point on a
/// circle, a meeting point of two circles, ±n of a face with SQ. `d` itself is returned when it
/// lies inside. In an empty region the answer is the candidate of the least region_violation(),
/// exact for two bounds in conflict. A tet on the plate is asked for the direction closest to z
/// instead (the first layer is flat).
Projection project_to_region(const FeasibleRegion& region, const Vec3& d);

}  // namespace s3
