#include "quaternion_field/concavity_weights.h"

#include <cmath>

#include <doctest/doctest.h>

#include "base/units.h"
#include "grid_mesh.h"
#include "scalar_field/scalar_field.h"

using namespace s3;

namespace {

// Layers that fall (slope < 0: a ridge) or rise (a valley) on both sides of the plane x = 1.
Values folded_layers_angles(const TetMesh& mesh, double slope) {
  Values g(mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    g(v) = mesh.vertices(v, 2) - slope * std::abs(mesh.vertices(v, 0) - 1);
  return concave_angles(mesh, make_scalar_field(mesh, g).print_direction);
}

bool shares_fold(const TetMesh& mesh, Eigen::Index pair) {
  const Vec3 a = mesh.centroid(mesh.face_pairs(pair, 0)),
             b = mesh.centroid(mesh.face_pairs(pair, 1));
  return (a.x() - 1) * (b.x() - 1) < 0;
}

}  // namespace

TEST_CASE("a valley is concave by twice its slope angle, a ridge convex, flat layers neither") {
  const TetMesh mesh = test::make_grid(2, 2, 2, Vec3(2, 2, 2));
  const double half = radians(15);
  const Values valley = folded_layers_angles(mesh, std::tan(half));
  const Values ridge = folded_layers_angles(mesh, -std::tan(half));
  int folds = 0;
  for (Eigen::Index i = 0; i < valley.size(); ++i) {
    const double expected = shares_fold(mesh, i) ? 2 * half : 0;
    folds += expected > 0;
    CHECK(valley(i) == doctest::Approx(-expected).epsilon(1e-12));
    CHECK(ridge(i) == doctest::Approx(expected).epsilon(1e-12));
  }
  CHECK(folds == 8);  // two triangles a cell face, 2×2 cell faces on the plane
  CHECK(count_concave_over(valley, radians(29.9)) == 8);
  CHECK(count_concave_over(valley, radians(30.1)) == 0);
  CHECK(count_concave_over(ridge, 0.01) == 0);
}

TEST_CASE("a head gouges where a valley is steeper than its clearance") {
  Values omega(4);
  omega << radians(-44), radians(-46), radians(80), radians(-59);
  CHECK(gouging_pairs(omega, radians(90)) == 2);   // clearance 45°
  CHECK(gouging_pairs(omega, radians(60)) == 0);   // 60°
  CHECK(gouging_pairs(omega, radians(100)) == 3);  // 40°
}

TEST_CASE("smoothness weights follow Eq. 11") {
  Values omega(3);
  omega << -0.5, 0.5, -2;
  const Values once = concavity_weights(omega, 1), cubed = concavity_weights(omega, 3);
  CHECK(once(0) == doctest::Approx(1.5));
  CHECK(once(1) == 1);
  CHECK(once(2) == doctest::Approx(3));
  CHECK(cubed(0) == doctest::Approx(1.125));
  CHECK(cubed(1) == 1);
  CHECK(cubed(2) == doctest::Approx(9));
}

TEST_CASE("a pair without a print direction has no angle") {
  const TetMesh mesh = test::make_grid(1, 1, 1, Vec3(1, 1, 1));
  Directions d = Vec3::UnitZ().transpose().replicate(mesh.tet_count(), 1);
  d.row(0).setZero();
  CHECK(concave_angles(mesh, d).isZero(0));
}
