#include <doctest/doctest.h>

#include <numeric>

#include "grid_mesh.h"
#include "objectives/objectives.h"

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
