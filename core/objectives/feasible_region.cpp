// Feasible regions on the Gauss sphere and the projection onto them (Sec. 3.1).
#include "objectives/feasible_region.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"
#include "objectives/gauss_sphere.h"

namespace s3 {

namespace {

// A point computed on a border must count as inside. Two circles that nearly touch meet with an
// error of the square root of the rounding error.
constexpr double kBorder = 1e-8;

// Four faces with one cap and two band circles each, the two circles of S, the machine's cone, and
// the rise.
constexpr int kMaxCircles = 4 * 3 + 2 + 1 + 1;

// A direction that the machine cannot reach is of no use, however well it suits the objectives
// (weights in [0, 1]).
constexpr double kOutOfReach = 100;

struct Circles {
  std::array<SphereCircle, kMaxCircles> list;
  int count = 0;
  void add(const Vec3& axis, double offset) { list[count++] = {axis, offset}; }
};

Circles circles_of(const FeasibleRegion& region) {
  const RegionBounds& b = region.bounds;
  Circles circles;
  for (int i = 0; i < region.face_count; ++i) {
    const FeasibleRegion::Face& face = region.faces[i];
    if (b.support_free > 0) circles.add(face.normal, -b.sin_alpha);
    if (!face.quality) continue;
    circles.add(face.normal, b.sin_gamma);
    circles.add(face.normal, -b.sin_gamma);
  }
  if (region.critical) {
    circles.add(region.tau, b.sin_beta);
    circles.add(region.tau, -b.sin_beta);
  }
  if (region.cos_tilt > -1) circles.add(build_direction(), region.cos_tilt);
  if (region.must_rise) circles.add(region.rise, kLeastRise);
  return circles;
}

double band_angle(double cosine, double sin_bound) {
  return std::max(0.0, std::asin(std::min(1.0, std::abs(cosine))) - std::asin(sin_bound));
}

double cap_angle(double cosine, double sin_bound) {
  return std::max(0.0, std::asin(std::min(1.0, -cosine)) - std::asin(sin_bound));
}

double quality_angle(const Vec3& normal, const Vec3& d, double sin_gamma) {
  const double to_normal = angle_between(normal, d);
  return std::min({band_angle(normal.dot(d), sin_gamma), to_normal, kPi - to_normal});
}

bool inside(const FeasibleRegion& region, const Vec3& d) {
  const RegionBounds& b = region.bounds;
  if (d.z() < region.cos_tilt - kBorder) return false;
  if (region.must_rise && region.rise.dot(d) < kLeastRise - kBorder) return false;
  for (int i = 0; i < region.face_count; ++i) {
    const FeasibleRegion::Face& face = region.faces[i];
    const double cosine = face.normal.dot(d);
    if (b.support_free > 0 && cosine < -b.sin_alpha - kBorder) return false;
    if (face.quality && std::abs(cosine) > b.sin_gamma + kBorder &&
        face.normal.cross(d).squaredNorm() > kBorder * kBorder)
      return false;
  }
  return !region.critical || std::abs(region.tau.dot(d)) <= b.sin_beta + kBorder;
}

// Calls visit(candidate) for every point that can be the closest one, d excepted.
template <class Visit>
void for_each_candidate(const FeasibleRegion& region, const Vec3& d, Visit&& visit) {
  const Circles circles = circles_of(region);
  for (int i = 0; i < circles.count; ++i) {
    visit(closest_on_circle(circles.list[i], d));
    for (int j = 0; j < i; ++j) {
      const CircleMeeting meeting = meeting_points(circles.list[i], circles.list[j]);
      for (int k = 0; k < meeting.count; ++k) visit(meeting.points[k]);
    }
  }
  for (int i = 0; i < region.face_count; ++i) {
    if (!region.faces[i].quality) continue;
    visit(region.faces[i].normal);
    visit(-region.faces[i].normal);
  }
}

Vec3 closest_inside(const FeasibleRegion& region, const Vec3& d, bool& found) {
  double best = -2;  // cosine of the distance
  Vec3 closest = d;
  for_each_candidate(region, d, [&](const Vec3& x) {
    const double cosine = x.dot(d);
    if (cosine <= best || !inside(region, x)) return;
    best = cosine;
    closest = x;
  });
  found = best > -2;
  return closest;
}

Vec3 least_violation(const FeasibleRegion& region, const Vec3& d) {
  Vec3 best = d;
  double least = region_violation(region, d);
  const auto visit = [&](const Vec3& x) {
    // Ties go to the candidate closer to d; the tolerance keeps rounding from deciding.
    const double violation = region_violation(region, x);
    if (violation > least + kBorder) return;
    if (violation > least - kBorder && x.dot(d) <= best.dot(d)) return;
    least = violation;
    best = x;
  };
  for_each_candidate(region, d, visit);
  // Bounds in conflict are missed least on the great circle through their axes.
  const Circles circles = circles_of(region);
  for (int i = 0; i < circles.count; ++i)
    for (int j = 0; j < circles.count; ++j) {
      if (i == j) continue;
      visit(closest_on_circle(circles.list[i], circles.list[j].axis));
      visit(closest_on_circle(circles.list[i], -circles.list[j].axis));
    }
  return best;
}

}  // namespace

RegionBounds region_bounds(const ObjectiveParams& params, double alpha_margin) {
  return {std::sin(radians(params.alpha_deg) - alpha_margin),
          std::sin(radians(params.beta_deg)),
          std::sin(radians(params.gamma_deg)),
          params.support_free,
          params.strength,
          params.surface_quality};
}

FeasibleRegion feasible_region(const ObjectiveField& objectives, const RegionBounds& bounds,
                               Index t) {
  FeasibleRegion region{.bounds = bounds, .faces = {}};
  for (Index i = objectives.tet_face_begin[t]; i < objectives.tet_face_begin[t + 1]; ++i) {
    const Index face = objectives.tet_faces[i];
    if (objectives.face_exempt[face]) {
      region.on_plate = true;
      continue;
    }
    const bool quality = objectives.face_wants_quality[face] != 0;
    if (quality || bounds.support_free > 0)
      region.faces[region.face_count++] = {objectives.face_normal.row(face), quality};
  }
  if (!objectives.critical.empty() && objectives.critical[t]) {
    region.critical = true;
    region.tau = objectives.tau_max.row(t);
  }
  return region;
}

double region_violation(const FeasibleRegion& region, const Vec3& d) {
  const RegionBounds& b = region.bounds;
  double sum = 0;
  for (int i = 0; i < region.face_count; ++i) {
    const FeasibleRegion::Face& face = region.faces[i];
    if (b.support_free > 0) sum += b.support_free * cap_angle(face.normal.dot(d), b.sin_alpha);
    if (face.quality) sum += b.surface_quality * quality_angle(face.normal, d, b.sin_gamma);
  }
  if (region.critical) sum += b.strength * band_angle(region.tau.dot(d), b.sin_beta);
  if (region.must_rise) sum += cap_angle(region.rise.dot(d), -kLeastRise);
  if (d.z() < region.cos_tilt)
    sum += kOutOfReach * (angle_between(d, build_direction()) - std::acos(region.cos_tilt));
  return sum;
}

Projection project_to_region(const FeasibleRegion& region, const Vec3& d) {
  const Vec3 wanted = region.on_plate ? build_direction() : d;
  Projection result{wanted, 0, true};
  if (!inside(region, wanted)) {
    result.direction = closest_inside(region, wanted, result.feasible);
    if (!result.feasible) result.direction = least_violation(region, wanted);
  }
  result.distance = angle_between(d, result.direction);
  return result;
}

}  // namespace s3
