#include "outer_loop/residual.h"

#include <cmath>

#include <doctest/doctest.h>

#include "base/units.h"
#include "grid_mesh.h"
#include "objectives/feasible_region.h"

using namespace s3;

namespace {

// Stands upright on its plate for 4 mm, then leans by `lean` towards +x.
TetMesh kinked_bar(double lean) {
  return test::make_grid(2, 2, 20, Vec3(4, 4, 20), [lean](const Vec3& p) {
    return Vec3(p.x() + std::tan(lean) * std::max(0.0, p.z() - 4), p.y(), p.z());
  });
}

}  // namespace

TEST_CASE("the residual of planar layers is the overhang beyond 45 degrees") {
  const TetMesh rest = kinked_bar(radians(60));
  const ObjectiveField objectives = make_objectives(rest, {}, nullptr);
  const Directions up = Vec3::UnitZ().transpose().replicate(rest.tet_count(), 1);
  Context ctx;
  const Residual pi = residual(objectives, {}, up, ctx);
  Index overhanging = 0;
  for (Index f = 0; f < rest.boundary_faces.rows(); ++f) {
    const Index t = rest.boundary_face_tet[static_cast<std::size_t>(f)];
    if (objectives.face_exempt[static_cast<std::size_t>(f)] || objectives.face_normal(f, 2) > -0.5)
      continue;
    ++overhanging;
    CHECK(pi.distance(t) == doctest::Approx(radians(15)));
  }
  CHECK(overhanging == 64);  // 16 rows of two cells, two triangles each
  CHECK(pi.mean * pi.tets == doctest::Approx(overhanging * radians(15)));
}

TEST_CASE("tets on the plate and inside the solid do not count") {
  const TetMesh rest = test::make_grid(4, 4, 4, Vec3(4, 4, 4));
  const ObjectiveField objectives = make_objectives(rest, {}, nullptr);
  const Directions sideways = Vec3::UnitX().transpose().replicate(rest.tet_count(), 1);
  Context ctx;
  const Residual pi = residual(objectives, {}, sideways, ctx);
  for (Index t = 0; t < rest.tet_count(); ++t) {
    const FeasibleRegion region = feasible_region(objectives, region_bounds({}), t);
    if (region.on_plate || region.face_count == 0) CHECK(pi.distance(t) == 0);
  }
  // On the side −x, layers that print towards +x overhang by 90°.
  CHECK(pi.distance.maxCoeff() == doctest::Approx(radians(45)));
}

TEST_CASE("a vanished gradient is as wrong as can be, and no objective asks nothing") {
  const TetMesh rest = test::make_grid(3, 3, 3, Vec3(3, 3, 3));
  Context ctx;
  const Directions none = Directions::Zero(rest.tet_count(), 3);
  CHECK(residual(make_objectives(rest, {}, nullptr), {}, none, ctx).mean == doctest::Approx(kPi));
  ObjectiveParams nothing;
  nothing.support_free = 0;
  CHECK(residual(make_objectives(rest, nothing, nullptr), nothing, none, ctx).mean == 0);
}
