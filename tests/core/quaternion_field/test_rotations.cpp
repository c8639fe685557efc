#include <doctest/doctest.h>

#include "base/units.h"
#include "grid_mesh.h"
#include "quaternion_field/rotations_from_deformation.h"

using namespace s3;

TEST_CASE(
    "a stretched and turned body gives its turn, and the direction that the turn brings to z") {
  const TetMesh rest = test::make_grid(2, 1, 2, Vec3(2, 1, 2));
  const Quat turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()));
  const Mat3 stretch = Vec3(1.3, 0.8, 1.1).asDiagonal();
  const Points deformed = rest.vertices * (turn.toRotationMatrix() * stretch).transpose();
  Context ctx;
  const Quats q =
      rotations_from_deformation(rest, deformed, identity_rotations(rest.tet_count()), ctx);
  for (Index t = 0; t < rest.tet_count(); ++t) {
    CHECK(std::abs(q.row(t).dot(turn.coeffs())) == doctest::Approx(1).epsilon(1e-12));
    CHECK((turn * print_direction_of(q.row(t)) - Vec3::UnitZ()).norm() < 1e-12);
  }
}

TEST_CASE("signs follow the previous field, through half a turn and beyond") {
  const TetMesh rest = test::make_grid(1, 1, 1, Vec3(1, 1, 1));
  Context ctx;
  Quats q = identity_rotations(rest.tet_count());
  for (int step = 1; step <= 9; ++step) {
    const Mat3 turn = Eigen::AngleAxisd(step * radians(40), Vec3::UnitY()).toRotationMatrix();
    q = rotations_from_deformation(rest, rest.vertices * turn.transpose(), q, ctx);
    CHECK(q(0, 3) == doctest::Approx(std::cos(step * radians(20))));
  }
}

TEST_CASE("flipped signs of single tets are aligned with their neighbours") {
  const TetMesh rest = test::make_grid(3, 3, 3, Vec3(1, 1, 1));
  Quats q = identity_rotations(rest.tet_count());
  for (Index t = 3; t < rest.tet_count(); t += 7) q.row(t) *= -1;
  align_signs(rest, q);
  CHECK(q == identity_rotations(rest.tet_count()));
}

TEST_CASE("pairs are incompatible from the paper's threshold on, whatever their signs") {
  const TetMesh rest = test::make_grid(1, 1, 1, Vec3(1, 1, 1));
  Quats q = identity_rotations(rest.tet_count());
  const auto turned = [](double chord) {  // ‖q − 1‖ = 2 sin(φ/4)
    return Quat(Eigen::AngleAxisd(4 * std::asin(chord / 2), Vec3::UnitX())).coeffs();
  };
  q.row(0) = turned(0.1199);
  CHECK(incompatible_pairs(rest, q) == 0);
  q.row(0) = -turned(0.1201);
  CHECK(incompatible_pairs(rest, q) == (rest.neighbors.row(0).array() >= 0).count());
}
