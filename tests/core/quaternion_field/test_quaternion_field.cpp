#include "quaternion_field/quaternion_field.h"

#include <doctest/doctest.h>

#include "base/units.h"
#include "grid_mesh.h"
#include "quaternion_field/rotations_from_deformation.h"

using namespace s3;

namespace {

// A bar that leans by `lean` from z: its lower side overhangs.
TetMesh leaning_bar(double lean) {
  return test::make_grid(4, 4, 16, Vec3(5, 5, 20), [lean](const Vec3& p) {
    return Vec3(p.x() + std::tan(lean) * p.z(), p.y(), p.z());
  });
}

// Largest angle by which a face that is not on the plate overhangs its layer, rad; faces under
// `lowest` are skipped.
double largest_overhang(const TetMesh& rest, const ObjectiveField& objectives, const Quats& q,
                        double lowest) {
  double largest = -1;
  for (Index f = 0; f < rest.boundary_faces.rows(); ++f) {
    const Index t = rest.boundary_face_tet[static_cast<std::size_t>(f)];
    if (objectives.face_exempt[static_cast<std::size_t>(f)] || rest.centroid(t).z() < lowest)
      continue;
    const Vec3 n = objectives.face_normal.row(f);
    largest = std::max(largest, std::asin(-n.dot(print_direction_of(q.row(t)))));
  }
  return largest;
}

}  // namespace

TEST_CASE("a solid without overhang keeps planar layers") {
  const TetMesh rest = test::make_grid(3, 3, 3, Vec3(3, 3, 3));
  const ObjectiveField objectives = make_objectives(rest, {}, nullptr);
  Context ctx;
  const Quats start = identity_rotations(rest.tet_count());
  const RotationField field = optimize_quaternion_field(
      rest, objectives, {}, start, Values::Ones(rest.face_pairs.rows()), 1, {}, ctx);
  CHECK((field.rotation - start).norm() < 1e-9);
}

TEST_CASE("the inner loop turns a leaning bar until its lower side supports itself") {
  const TetMesh rest = leaning_bar(radians(60));
  const ObjectiveField objectives = make_objectives(rest, {}, nullptr);
  Context ctx;
  const Quats start = identity_rotations(rest.tet_count());
  CHECK(largest_overhang(rest, objectives, start, 5) == doctest::Approx(radians(60)));
  const RotationField field =
      optimize_quaternion_field(rest, objectives, {}, start, Values::Ones(rest.face_pairs.rows()),
                                1, {.inner_iterations = 20}, ctx);
  CHECK(field.infeasible_tets == 0);
  CHECK(largest_overhang(rest, objectives, field.rotation, 5) < radians(45.01));
  for (Index t = 0; t < rest.tet_count(); ++t)
    CHECK(field.rotation.row(t).norm() == doctest::Approx(1));
}

TEST_CASE("targets bring the closest feasible direction to z without twist") {
  const TetMesh rest = leaning_bar(radians(60));
  const ObjectiveField objectives = make_objectives(rest, {}, nullptr);
  Context ctx;
  const Quats start = identity_rotations(rest.tet_count());
  const RotationField field =
      optimize_quaternion_field(rest, objectives, {}, start, Values::Ones(rest.face_pairs.rows()),
                                1, {.inner_iterations = 0, .alpha_margin = radians(3)}, ctx);
  int moved = 0;
  for (Index t = 0; t < rest.tet_count(); ++t) {
    const double twist = field.target_rotation(t, 2);  // about z, from an upright start
    CHECK(std::abs(twist) < 1e-12);
    if (std::abs(field.target_rotation(t, 3)) > 1 - 1e-12) continue;
    ++moved;
    // The lower side leans by 60° and is asked for 45° − 3°: a turn of 18°.
    CHECK(2 * std::acos(field.target_rotation(t, 3)) == doctest::Approx(radians(18)));
  }
  CHECK(moved > 0);
}

TEST_CASE("switches of Eq. 9 count violated objectives only, and the plate holds") {
  const TetMesh rest = leaning_bar(radians(60));
  ObjectiveParams params;
  params.support_free = 0.7;
  const ObjectiveField objectives = make_objectives(rest, params, nullptr);
  Context ctx;
  const Values upright =
      keep_weights(objectives, region_bounds(params), identity_rotations(rest.tet_count()), ctx);
  Quats turned = identity_rotations(rest.tet_count());
  const Quat by_30(Eigen::AngleAxisd(radians(-30), Vec3::UnitY()));
  for (Index t = 0; t < rest.tet_count(); ++t) turned.row(t) = by_30.coeffs();
  const Values leaning = keep_weights(objectives, region_bounds(params), turned, ctx);
  for (Index t = 0; t < rest.tet_count(); ++t) {
    const FeasibleRegion region = feasible_region(objectives, region_bounds(params), t);
    bool overhangs = false;
    for (int i = 0; i < region.face_count; ++i)
      overhangs = overhangs || region.faces[static_cast<std::size_t>(i)].normal.z() < -0.75;
    if (region.on_plate) {
      CHECK(upright(t) > 1);
    } else {
      CHECK(upright(t) == (overhangs ? 0.7 : 0.0));
      CHECK(leaning(t) == 0);
    }
  }
}

TEST_CASE("the field does not depend on the number of threads") {
  const TetMesh rest = leaning_bar(radians(60));
  const ObjectiveField objectives = make_objectives(rest, {}, nullptr);
  const Quats start = identity_rotations(rest.tet_count());
  const Values smooth = Values::Ones(rest.face_pairs.rows());
  Context one(1), three(3);
  CHECK(optimize_quaternion_field(rest, objectives, {}, start, smooth, 1, {}, one).rotation ==
        optimize_quaternion_field(rest, objectives, {}, start, smooth, 1, {}, three).rotation);
}
