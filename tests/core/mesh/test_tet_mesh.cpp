#include <doctest/doctest.h>

#include "base/error.h"
#include "grid_mesh.h"
#include "mesh/tet_mesh.h"

using namespace s3;

TEST_CASE("a box of tets has the box's volume, surface and closed topology") {
  const TetMesh mesh = test::make_grid(3, 2, 4, Vec3(3, 4, 5));
  CHECK(tet_volumes(mesh).sum() == doctest::Approx(60));
  CHECK(tet_volumes(mesh).minCoeff() > 0);
  const TriMesh surface = boundary_surface(mesh);
  CHECK(surface_area(surface) == doctest::Approx(2 * (12 + 15 + 20)));
  CHECK(enclosed_volume(surface) == doctest::Approx(60));
  CHECK(4 * mesh.tet_count() == 2 * mesh.face_pairs.rows() + mesh.boundary_faces.rows());
}

TEST_CASE("shared faces of a pair have the same corners") {
  const TetMesh mesh = test::make_grid(2, 2, 2, Vec3(1, 1, 1));
  for (Eigen::Index p = 0; p < mesh.face_pairs.rows(); ++p) {
    const Index a = mesh.face_pairs(p, 0), b = mesh.face_pairs(p, 1);
    CHECK(mesh.neighbors(a, mesh.face_pair_local(p, 0)) == b);
    CHECK(mesh.neighbors(b, mesh.face_pair_local(p, 1)) == a);
  }
}

TEST_CASE("hat gradients reproduce the gradient of a linear function") {
  const TetMesh mesh = test::make_grid(2, 1, 2, Vec3(1, 2, 3));
  const Vec3 slope(0.3, -1.2, 2.0);
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    Eigen::Vector4d values;
    for (int i = 0; i < 4; ++i) values(i) = slope.dot(mesh.corner(t, i)) + 7;
    CHECK((hat_gradients(mesh, t) * values - slope).norm() < 1e-12);
  }
}

TEST_CASE("a face shared by three tets is an error") {
  Points v(6, 3);
  v << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0.1, 0.1, 2;
  Tets t(3, 4);
  t << 0, 1, 2, 3, 0, 2, 1, 4, 0, 1, 2, 5;
  CHECK_THROWS_AS(make_tet_mesh(v, t), Error);
}
