#include <doctest/doctest.h>

#include <cmath>

#include "base/units.h"
#include "carved_mesh.h"
#include "scalar_field/tilt_limit.h"

using namespace s3;

namespace {

struct Setup {
  Context ctx;
  TetMesh mesh = test::make_table();
  FieldOperators operators{mesh, ctx};
  Anchors anchors = find_anchors(mesh, make_objectives(mesh, {}, nullptr));

  // Planar layers with waves of this height.
  Values waves(double height) const {
    Values value = anchors.planar;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
      if (anchors.free_index[v] >= 0)
        value(v) += height * std::sin(1.7 * mesh.vertices(v, 0)) *
                    std::cos(2.3 * mesh.vertices(v, 1) + mesh.vertices(v, 2));
    return value;
  }
};

}  // namespace

TEST_CASE("a field within the machine's cone is left alone") {
  Setup s;
  const Values value = s.waves(0.1);
  REQUIRE(count_tilted(s.mesh, s.operators, value, radians(60)) == 0);
  CHECK(limit_tilt(s.mesh, s.operators, s.anchors, value, radians(60), s.ctx) == value);
}

TEST_CASE("whatever the field, no tet is outside the machine's cone afterwards") {
  Setup s;
  for (const double height : {2.0, 10.0, 50.0})
    for (const double limit : {15.0, 45.0, 75.0, 88.0}) {
      const Values value = s.waves(height);
      CHECK(count_tilted(s.mesh, s.operators, value, radians(limit)) > 0);
      const Values limited =
          limit_tilt(s.mesh, s.operators, s.anchors, value, radians(limit), s.ctx);
      CHECK(count_tilted(s.mesh, s.operators, limited, radians(limit)) == 0);
      for (Index v = 0; v < s.mesh.vertex_count(); ++v)
        if (s.anchors.free_index[v] < 0) CHECK(limited(v) == doctest::Approx(0));
    }
}

TEST_CASE("a dent in one place is repaired there and not by flattening the whole part") {
  Setup s;
  Values value = s.anchors.planar;
  for (Index v = 0; v < s.mesh.vertex_count(); ++v) {
    value(v) += 0.5 * s.mesh.vertices(v, 0) * s.mesh.vertices(v, 2) / 14;  // a slope everywhere
    if ((s.mesh.vertices.row(v) - Eigen::RowVector3d(8, 8, 7)).norm() < 0.5) value(v) -= 1.5;
  }
  REQUIRE(count_tilted(s.mesh, s.operators, value, radians(80)) > 0);
  const Values limited = limit_tilt(s.mesh, s.operators, s.anchors, value, radians(80), s.ctx);
  CHECK(count_tilted(s.mesh, s.operators, limited, radians(80)) == 0);
  for (Index v = 0; v < s.mesh.vertex_count(); ++v)
    if (s.mesh.vertices(v, 2) > 12) CHECK(std::abs(limited(v) - value(v)) < 0.3);
}
