#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "base/units.h"
#include "objectives/feasible_region.h"
#include "objectives/gauss_sphere.h"

using namespace s3;

namespace {

constexpr double kTiny = 1e-12;

RegionBounds bounds(double sf, double sr, double sq) {
  ObjectiveParams params;
  params.support_free = sf;
  params.strength = sr;
  params.surface_quality = sq;
  return region_bounds(params);
}

FeasibleRegion region_of(const std::vector<Vec3>& normals, const RegionBounds& b) {
  FeasibleRegion region{.bounds = b, .faces = {}};
  for (const Vec3& n : normals)
    region.faces[region.face_count++] = {n.normalized(), b.surface_quality > 0};
  return region;
}

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vec3 d(normal(random), normal(random), normal(random));
  return d.normalized();
}

// Evenly spread points (a spiral), about 0.5 degrees apart.
const std::vector<Vec3>& sphere_samples() {
  static const std::vector<Vec3> samples = [] {
    constexpr int kCount = 200000;
    std::vector<Vec3> points;
    const double golden = kPi * (3 - std::sqrt(5.0));
    for (int i = 0; i < kCount; ++i) {
      const double z = 1 - (2.0 * i + 1) / kCount, r = std::sqrt(1 - z * z);
      points.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
    }
    return points;
  }();
  return samples;
}

// A direction in the plane of n and a right angle to it, `angle` away from n.
Vec3 leaning(const Vec3& n, double angle) {
  return std::cos(angle) * n + std::sin(angle) * any_perpendicular(n);
}

}  // namespace

TEST_CASE("an overhang of one cap is turned by exactly the angle that it misses") {
  const RegionBounds b = bounds(1, 0, 0);
  const Vec3 n = Vec3(0.3, -0.2, -0.9).normalized();
  const FeasibleRegion region = region_of({n}, b);
  for (const double angle : {kPi, 0.99 * kPi, radians(160), radians(140), radians(135) + 1e-6}) {
    const Vec3 d = leaning(n, angle);
    const Projection p = project_to_region(region, d);
    CHECK(p.feasible);
    CHECK(p.distance == doctest::Approx(angle - radians(135)).epsilon(1e-9));
    CHECK(angle_between(p.direction, n) == doctest::Approx(radians(135)));
  }
}

TEST_CASE("a direction inside its region stays as it is, on either side of the border by 1e-12") {
  const Vec3 n = Vec3(1, 2, -3).normalized();
  const FeasibleRegion cap = region_of({n}, bounds(1, 0, 0));
  const FeasibleRegion band = region_of({n}, bounds(0, 0, 1));
  for (const double shift : {-kTiny, 0.0, kTiny}) {
    const Vec3 at_cap = leaning(n, radians(135) + shift);
    CHECK((project_to_region(cap, at_cap).direction - at_cap).norm() < 1e-11);
    CHECK(region_violation(cap, at_cap) < 1e-11);
    const Vec3 at_band = leaning(n, radians(90 - 20) + shift);
    CHECK((project_to_region(band, at_band).direction - at_band).norm() < 1e-11);
    // The other side of SQ: the normal itself is a point of the region.
    const Vec3 at_normal = leaning(n, shift);
    CHECK((project_to_region(band, at_normal).direction - at_normal).norm() < 1e-11);
    // Opposite to the normal all ways out of the overhang are equal; any of them will do.
    CHECK(project_to_region(cap, leaning(n, kPi + shift)).distance == doctest::Approx(radians(45)));
  }
}

TEST_CASE("surface quality goes to the normal or to the band, whichever is closer") {
  const Vec3 n = Vec3::UnitX();
  const FeasibleRegion region = region_of({n}, bounds(0, 0, 1));  // band starts 70 degrees from n
  CHECK((project_to_region(region, leaning(n, radians(34))).direction - n).norm() < 1e-12);
  CHECK(angle_between(project_to_region(region, leaning(n, radians(36))).direction, n) ==
        doctest::Approx(radians(70)));
  CHECK((project_to_region(region, leaning(n, radians(179))).direction + n).norm() < 1e-12);
}

TEST_CASE("where support free forbids the far side of the normal, only the near side counts") {
  const Vec3 n = Vec3::UnitX();
  const FeasibleRegion region = region_of({n}, bounds(1, 0, 1));
  const Projection p = project_to_region(region, -n);
  CHECK(p.feasible);
  CHECK(angle_between(p.direction, n) == doctest::Approx(radians(110)));
}

TEST_CASE("the projection agrees with a search over the sphere for every mix of objectives") {
  std::mt19937 random(7);
  int checked = 0, empty = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const int objectives = 1 + trial % 7;
    FeasibleRegion region = region_of({}, bounds(objectives & 1, objectives & 2, objectives & 4));
    const int faces = 1 + trial % 3;
    for (int i = 0; i < faces; ++i)
      region.faces[region.face_count++] = {random_direction(random), (objectives & 4) != 0};
    if (objectives & 2) {
      region.critical = true;
      region.tau = random_direction(random);
    }
    if (trial % 4 == 1) region.cos_tilt = std::cos(radians(60));
    if (trial % 5 == 2) {
      region.must_rise = true;
      region.rise = random_direction(random);
    }
    const Vec3 d = random_direction(random);
    const Projection p = project_to_region(region, d);

    // Points ±n are too small for samples to hit: they join the search.
    double nearest = 10, least = 1e9;
    const auto visit = [&](const Vec3& x) {
      const double violation = region_violation(region, x);
      least = std::min(least, violation);
      if (violation < 1e-9) nearest = std::min(nearest, angle_between(x, d));
    };
    for (const Vec3& x : sphere_samples()) visit(x);
    for (int i = 0; i < region.face_count; ++i) {
      visit(region.faces[i].normal);
      visit(-region.faces[i].normal);
    }
    constexpr double kSpacing = 0.02;  // rad: samples are this close to any border point
    CHECK(std::abs(p.direction.norm() - 1) < 1e-9);
    CHECK(p.distance == doctest::Approx(angle_between(p.direction, d)));
    if (p.feasible) {
      CHECK(region_violation(region, p.direction) < 1e-6);
      CHECK(p.distance <= nearest + 1e-9);
      if (nearest < 10) {
        // A sliver between two borders has its tip further from the samples than a plain border.
        CHECK(p.distance >= nearest - 5 * kSpacing);
        ++checked;
      }
    } else {
      CHECK(nearest == 10);
      // Exact for two bounds; with more in conflict the best candidate may miss the optimum.
      CHECK(region_violation(region, p.direction) < least * 1.15 + kSpacing);
      ++empty;
    }
  }
  CHECK(checked > 40);
  CHECK(empty > 2);
}

TEST_CASE("demands that nothing satisfies are reported and missed as little as possible") {
  // Two upright walls leave ±z; SR wants a right angle to the diagonal of the cube, which leaves ±x
  // and ±y out too.
  ObjectiveParams params;
  params.support_free = 0;
  params.strength = params.surface_quality = 1;
  params.gamma_deg = 5;
  FeasibleRegion region = region_of({Vec3::UnitX(), Vec3::UnitY()}, region_bounds(params));
  CHECK(project_to_region(region, Vec3::UnitX()).feasible);
  region.critical = true;
  region.tau = Vec3(1, 1, 1).normalized();
  const Projection p = project_to_region(region, Vec3(0.2, 0.1, 0.9).normalized());
  CHECK_FALSE(p.feasible);
  // The corner of both bands that leans away from the diagonal: a turn costs the walls more than it
  // gains for SR.
  const double a = std::sin(radians(5)), c = std::sqrt(1 - 2 * a * a);
  CHECK((p.direction - Vec3(-a, -a, c)).norm() < 1e-9);
  const double best = std::asin((c - 2 * a) / std::sqrt(3.0)) - radians(10);
  CHECK(region_violation(region, p.direction) == doctest::Approx(best));
}

TEST_CASE("a tet on the plate asks for z, or what is closest to it beside an overhanging wall") {
  FeasibleRegion region = region_of({}, bounds(1, 0, 0));
  region.on_plate = true;
  CHECK_FALSE(region.constrained());
  const Vec3 d = Vec3(1, 0, 1).normalized();
  CHECK((project_to_region(region, d).direction - Vec3::UnitZ()).norm() < 1e-12);
  CHECK(project_to_region(region, d).distance == doctest::Approx(radians(45)));
  const Vec3 wall = leaning(Vec3::UnitZ(), radians(150));
  region.faces[region.face_count++] = {wall, false};
  CHECK(angle_between(project_to_region(region, d).direction, Vec3::UnitZ()) ==
        doctest::Approx(radians(15)));
}

TEST_CASE("a margin makes the support-free cap smaller by that angle") {
  ObjectiveParams params;
  const FeasibleRegion region = region_of({-Vec3::UnitZ()}, region_bounds(params, radians(3)));
  CHECK(project_to_region(region, Vec3::UnitZ()).distance == doctest::Approx(radians(48)));
}
