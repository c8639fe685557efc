#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/units.h"
#include "grid_mesh.h"
#include "metrics/lpd_metrics.h"
#include "objectives/feasible_region.h"
#include "objectives/objectives.h"
#include "outer_loop/residual.h"

using namespace s3;

TEST_CASE("the faces of a cube have their normals, areas and tets") {
  const TetMesh cube = test::make_grid(3, 3, 3, Vec3(20, 20, 20));
  ObjectiveParams params;
  params.surface_quality = 1;
  const ObjectiveField field = make_objectives(cube, params, nullptr);
  CHECK(field.face_area.sum() == doctest::Approx(6 * 400));
  Vec3 closed = Vec3::Zero();
  for (Eigen::Index f = 0; f < field.face_area.size(); ++f)
    closed += field.face_area(f) * field.face_normal.row(f).transpose();
  CHECK(closed.norm() < 1e-9);
  // Every face is listed once, under its own tet.
  std::size_t listed = 0;
  for (const Index t : field.boundary_tets)
    for (Index i = field.tet_face_begin[t]; i < field.tet_face_begin[t + 1]; ++i, ++listed)
      CHECK(cube.boundary_face_tet[field.tet_faces[i]] == t);
  CHECK(listed == cube.boundary_face_tet.size());
  CHECK(field.critical.empty());
}

TEST_CASE("the plate contact is the bottom: its vertices are held, its faces ask for nothing") {
  const TetMesh cube = test::make_grid(3, 3, 3, Vec3(20, 20, 20));
  ObjectiveParams params;
  params.surface_quality = 1;
  const ObjectiveField field = make_objectives(cube, params, nullptr);
  for (Index v = 0; v < cube.vertex_count(); ++v)
    CHECK((field.vertex_on_plate[v] != 0) == (cube.vertices(v, 2) == 0));
  double exempt = 0;
  for (std::size_t f = 0; f < field.face_exempt.size(); ++f) {
    if (field.face_exempt[f]) exempt += field.face_area(static_cast<Eigen::Index>(f));
    CHECK(field.face_wants_quality[f] == !field.face_exempt[f]);
  }
  CHECK(exempt == doctest::Approx(400));
}

TEST_CASE("a part with a round bottom stands on its lowest vertices") {
  // A cube on its corner: the lowest vertex alone touches the plate.
  const Quat turn = Quat::FromTwoVectors(Vec3(1, 1, 1), Vec3::UnitZ());
  const TetMesh cube =
      test::make_grid(2, 2, 2, Vec3(10, 10, 10), [&](const Vec3& p) { return Vec3(turn * p); });
  const ObjectiveField field = make_objectives(cube, {}, nullptr);
  CHECK(std::accumulate(field.vertex_on_plate.begin(), field.vertex_on_plate.end(), 0) == 1);
  CHECK(field.vertex_on_plate[0] == 1);
}

TEST_CASE("critical tets and their directions come from the stress field, with SR only") {
  const TetMesh cube = test::make_grid(1, 1, 1, Vec3(1, 1, 1));
  StressField stress;
  stress.principal = Directions::Zero(6, 3);
  stress.principal.col(0).setOnes();
  stress.critical_tets = {1, 4};
  ObjectiveParams params;
  CHECK(make_objectives(cube, params, &stress).critical.empty());
  params.strength = 1;
  const ObjectiveField field = make_objectives(cube, params, &stress);
  CHECK(field.critical == std::vector<char>{0, 1, 0, 0, 1, 0});
  CHECK(field.tau_max == stress.principal);
}

TEST_CASE("a region for SQ: faces elsewhere ask nothing, count nothing and have no share in Π") {
  // Tilted by 30° about y, layers meet top, plate and the walls at ±x badly, those at ±y upright.
  const TetMesh cube = test::make_grid(4, 4, 4, Vec3(10, 10, 10));
  const Vec3 tilted(std::sin(radians(30)), 0, std::cos(radians(30)));
  const Directions d = tilted.transpose().replicate(cube.tet_count(), 1);
  ObjectiveParams params;
  params.support_free = 0;
  params.surface_quality = 1;
  const auto wall = [](const Vec3& point, const Vec3& normal) {
    return Region{"wall", {PlaneContact{point, normal, {}}}};
  };
  Context ctx;
  const auto check = [&](const Region* region, double wanted_area, double smooth_percent) {
    const ObjectiveField field = make_objectives(cube, params, nullptr, region);
    double wanted = 0;
    for (std::size_t f = 0; f < field.face_wants_quality.size(); ++f)
      if (field.face_wants_quality[f]) wanted += field.face_area(static_cast<Eigen::Index>(f));
    CHECK(wanted == doctest::Approx(wanted_area));
    Metrics metrics;
    lpd_metrics(lpd_angles(cube, field, nullptr, d), metrics);
    CHECK(*metrics.surface_quality_area_percent == doctest::Approx(40));  // of the whole surface
    CHECK(metrics.surface_quality_region_percent.has_value() == (region != nullptr));
    if (region != nullptr)
      CHECK(*metrics.surface_quality_region_percent == doctest::Approx(smooth_percent));
    return residual(field, params, d, ctx);
  };
  const Region good = wall({0, 10, 0}, Vec3::UnitY()), bad = wall({10, 0, 0}, Vec3::UnitX());
  CHECK(check(nullptr, 500, 0).mean > 0);
  CHECK(check(&good, 100, 100).mean == 0);
  const Residual missed = check(&bad, 100, 0);
  const ObjectiveField field = make_objectives(cube, params, nullptr, &bad);
  const RegionBounds bounds = region_bounds(params);
  Index asked = 0;
  for (Index t = 0; t < cube.tet_count(); ++t) {
    const FeasibleRegion region = feasible_region(field, bounds, t);
    const bool at_wall =
        std::any_of(region.faces.begin(), region.faces.begin() + region.face_count,
                    [](const FeasibleRegion::Face& face) { return face.normal.x() > 0.9; });
    if (at_wall) ++asked;
    // 30° from upright to the wall, 20° are allowed.
    const double expected = at_wall && !region.on_plate ? radians(10) : 0.0;
    CHECK(missed.distance(t) == doctest::Approx(expected));
  }
  CHECK(asked > 0);
}

TEST_CASE("a region for SQ without faces is an error of the objectives") {
  const TetMesh cube = test::make_grid(2, 2, 2, Vec3(10, 10, 10));
  const Region away{"away", {SphereRegion{Vec3(100, 0, 0), 1}}};
  try {
    make_objectives(cube, {}, nullptr, &away);
    FAIL("no error");
  } catch (const Error& error) {
    CHECK(error.stage == Stage::objectives);
    CHECK(error.code == "objectives.empty_region");
  }
}
