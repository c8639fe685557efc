#include <doctest/doctest.h>

#include <cmath>

#include "base/units.h"
#include "grid_mesh.h"
#include "scalar_field/heat_distance.h"

using namespace s3;

namespace {

/// A bar of square section, bent by `turn` radians about an axis parallel to y, the middle of its
/// section on a circle of radius r. It stands on the plate and leans to +x.
TetMesh bent_bar(double r, double side, double turn, int along) {
  return test::make_grid(4, 4, along, Vec3(side, side, turn), [&](const Vec3& p) {
    const double own = r + 0.5 * side - p.x();  // distance to the axis at x = r
    return Vec3(r - own * std::cos(p.z()), p.y(), own * std::sin(p.z()));
  });
}

Anchors anchors_of(const TetMesh& mesh) {
  return find_anchors(mesh, make_objectives(mesh, {}, nullptr));
}

}  // namespace

TEST_CASE("the heat distance of a box is its height, whatever its proportions") {
  Context ctx;
  // Below the top heat hardly falls any more: there the mesh decides by a few degrees.
  for (const Vec3& size : {Vec3(6, 4, 5), Vec3(2, 2, 60), Vec3(30, 30, 2)}) {
    CAPTURE(size.z());
    const TetMesh mesh = test::make_grid(5, 5, 12, size);
    const FieldOperators operators(mesh, ctx);
    const Anchors anchors = anchors_of(mesh);
    const Values distance = heat_distance(mesh, operators, anchors, ctx);
    CHECK((distance - mesh.vertices.col(2)).cwiseAbs().maxCoeff() < 0.03 * size.z());
    const Directions direction = heat_directions(mesh, operators, anchors, ctx);
    CHECK(direction.col(2).minCoeff() > std::cos(radians(10)));
    for (Index t = 0; t < mesh.tet_count(); ++t)
      if (mesh.centroid(t).z() < 0.5 * size.z()) CHECK(direction(t, 2) > std::cos(radians(2)));
  }
}

TEST_CASE("the heat distance of a bent bar is the length of the bar, also where it leads down") {
  Context ctx;
  constexpr double r = 20, side = 2;
  const double turn = radians(170);
  const TetMesh mesh = bent_bar(r, side, turn, 60);
  const FieldOperators operators(mesh, ctx);
  const Anchors anchors = anchors_of(mesh);
  const Values distance = heat_distance(mesh, operators, anchors, ctx);
  // Along the middle r φ; straight lines cut the inner side: between the inner arc and the middle.
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const double phi = std::atan2(mesh.vertices(v, 2), r - mesh.vertices(v, 0));
    if (phi < radians(10)) continue;
    CHECK(distance(v) > (r - 0.5 * side) * phi * 0.98 - 0.5 * side);
    CHECK(distance(v) < (r + 0.5 * side) * phi * 1.02 + 0.5 * side);
  }
  const Directions direction = heat_directions(mesh, operators, anchors, ctx);
  double worst = 1;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    const Vec3 c = mesh.centroid(t);
    const double phi = std::atan2(c.z(), r - c.x());
    if (phi < radians(10)) continue;  // flat on the plate first
    worst = std::min(worst, direction.row(t).dot(Vec3(std::sin(phi), 0, std::cos(phi))));
  }
  CHECK(worst > std::cos(radians(12)));
}

TEST_CASE("heat reaches the end of a path that is far longer than the part") {
  Context ctx;
  constexpr double r = 1.5, side = 0.8, pitch = 1.2;
  const double turn = radians(1800);  // a wire that rises in five turns
  const TetMesh mesh = test::make_grid(2, 2, 400, Vec3(side, side, turn), [&](const Vec3& p) {
    const double own = r + 0.5 * side - p.x();
    return Vec3(own * std::cos(p.z()), own * std::sin(p.z()), p.y() + pitch * p.z() / (2 * kPi));
  });
  const FieldOperators operators(mesh, ctx);
  const Values distance = heat_distance(mesh, operators, anchors_of(mesh), ctx);
  // From the lower end to the upper one, between the wire's inner side and its middle.
  const double rise = pitch / (2 * kPi);
  CHECK(distance.maxCoeff() < 1.05 * turn * std::hypot(r, rise));
  CHECK(distance.maxCoeff() > 0.95 * turn * std::hypot(r - 0.5 * side, rise));
}
