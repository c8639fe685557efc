#include "toolpaths/line_quality.h"

#include <doctest/doctest.h>

#include <cmath>

#include "layer_shapes.h"

using namespace s3;
using namespace s3::test;

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

Path straight(const Vec3& a, const Vec3& b, PathKind kind) {
  Path path;
  path.kind = kind;
  path.points.resize(2, 3);
  path.points << a.transpose(), b.transpose();
  path.normals = Directions::Zero(2, 3);
  path.normals.col(2).setOnes();
  path.thickness.setConstant(2, 0.4);
  path.width.setConstant(2, 1.0);
  return path;
}

/// Lines along x at y = ½, 3/2, …, from beyond the square's left, top and bottom edge to walls that
/// they run into at an angle.
struct Pattern {
  double angle_deg = 90;
  double to_wall = 0.95;  // mm from the lines' ends to the first wall
  int left_out = 1000;    // number of a line
};

LineQuality measured(const Pattern& pattern) {
  const Layer layer = make_rectangle(40, 40, 0.8);
  const double angle = pattern.angle_deg * kDegree;
  const Vec3 along(std::cos(angle), std::sin(angle), 0), away(std::sin(angle), -std::cos(angle), 0);
  constexpr int kWalls = 15, kLines = 50;
  std::vector<Path> paths;
  paths.reserve(kWalls + kLines);
  for (int k = 0; k < kWalls; ++k)
    paths.push_back(straight(-60 * along + k * away, 60 * along + k * away, PathKind::wall));
  for (int k = -kLines / 2; k < kLines / 2; ++k) {
    if (k == pattern.left_out) continue;
    // The end (x, y) has the distance −(x, y)·away from the first wall, which runs through 0.
    const double y = k + 0.5, x = (y * std::cos(angle) - pattern.to_wall) / std::sin(angle);
    paths.push_back(straight({-80, y, 0}, {x, y, 0}, PathKind::infill));
  }
  LayerStress stress;
  stress.direction = Directions::Zero(layer.surface.triangles.rows(), 3);
  stress.critical.assign(static_cast<std::size_t>(layer.surface.triangles.rows()), 0);
  const Context ctx;
  return measure_lines(
      {layer.surface.vertices, layer.normal, layer.thickness, layer.surface.triangles}, stress,
      paths, 1.0, ctx);
}

double even_share(const LineQuality& lines) {
  return lines.spacing.between(0.425, 0.575);
}

}  // namespace

TEST_CASE("lines a bead apart are even, whatever the angle at which they run into a wall") {
  for (const double angle : {50.0, 60.0, 75.0, 90.0, 105.0, 130.0}) {
    CAPTURE(angle);
    const LineQuality lines = measured({.angle_deg = angle});
    // All but what no bead covers: between two ends and the wall.
    CHECK(even_share(lines) > 0.99);
    CHECK(lines.spacing.total() > 0.9 * 0.5 * 40 * 39);  // little is left out
  }
}

TEST_CASE("the wedge between a line and a wall that runs nearly along it is uneven") {
  // One bead across is 1/tan 20° = 2.7 along: not a matter of the line's end.
  const LineQuality lines = measured({.angle_deg = 20});
  const double wedges = 40 * std::cos(20 * kDegree) * 0.5 * (1.15 + 0.95 + 1) / 2;  // roughly, mm²
  CHECK(1 - even_share(lines) > 0.5 * wedges / (0.5 * 40 * 40));
  CHECK(1 - even_share(lines) < 2.0 * wedges / (0.5 * 40 * 40));
}

TEST_CASE("a line left out is a gap of two beads, and lines that end too early leave one") {
  const LineQuality gap = measured({.left_out = 3});
  CHECK((1 - even_share(gap)) * gap.spacing.total() == doctest::Approx(2 * 19.0).epsilon(0.1));
  // 3 mm before the wall: what lies farther than half a bead and nearer than one from the ends.
  const LineQuality early = measured({.to_wall = 3});
  CHECK((1 - even_share(early)) * early.spacing.total() > 0.3 * 40);
}
