#include "mesh/placement.h"

#include <doctest/doctest.h>

#include "base/error.h"
#include "base/units.h"
#include "grid_mesh.h"
#include "mesh/tri_mesh.h"

using namespace s3;

namespace {

TriMesh box(const Vec3& size) {
  return boundary_surface(test::make_grid(2, 2, 2, size));
}

TriMesh turned(TriMesh mesh, const Eigen::AngleAxisd& rotation) {
  transform_points(Eigen::Affine3d(rotation), mesh.vertices);
  return mesh;
}

}  // namespace

TEST_CASE("y-up files are turned as the authors' models ask, and stand on the plate") {
  Points p(3, 3);
  p << 1, 2, 3, 4, -5, 6, 7, 8, 9;
  const Eigen::Affine3d t = placement(p, {}, {.up = "y", .scale = 2});
  transform_points(t, p);
  Points expected(3, 3);
  expected << 2, -6, 14, 8, -12, 0, 14, -18, 26;  // (x, −z, y)·2, then up by 10
  CHECK((p - expected).norm() < 1e-12);
}

TEST_CASE("rotation turns about x, then y, then z, and keeps x and y in place") {
  Points p(2, 3);
  p << 1, 0, 0, 0, 0, 1;
  const Eigen::Affine3d t = placement(p, {}, {.rotate = "90, 0,-90"});
  // (1,0,0) → x: same → z by −90: (0,−1,0).   (0,0,1) → x by 90: (0,−1,0) → z by −90: (−1,0,0).
  CHECK((t * Vec3(1, 0, 0) - Vec3(0, -1, 0)).norm() < 1e-12);
  CHECK((t * Vec3(0, 0, 1) - Vec3(-1, 0, 0)).norm() < 1e-12);
  CHECK((t.rotation() * t.rotation().transpose() - Mat3::Identity()).norm() < 1e-12);
}

TEST_CASE("placement refuses parameters that mean nothing") {
  const Points p = Points::Zero(1, 3);
  CHECK_THROWS_AS(placement(p, {}, {.up = "x"}), Error);
  CHECK_THROWS_AS(placement(p, {}, {.scale = 0}), Error);
  for (const char* rotate : {"", "1,2", "1,2,3,4", "1,2,x", "1;2;3", "1,,2", "1 1,2,3"})
    CHECK_THROWS_AS(placement(p, {}, {.rotate = rotate}), Error);
}

TEST_CASE("a tilted box is laid on its largest side") {
  const TriMesh mesh =
      turned(box(Vec3(10, 20, 3)), Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  const Eigen::Affine3d t = placement(mesh.vertices, mesh.triangles, {.rotate = "auto"});
  Points p = mesh.vertices;
  transform_points(t, p);
  const Box b = bounding_box(p);
  CHECK(b.min.z() == doctest::Approx(0));
  CHECK(b.max.z() == doctest::Approx(3));
  CHECK(t.linear().determinant() == doctest::Approx(1));
}

TEST_CASE("a model that stands well is left as it is") {
  const TriMesh mesh = box(Vec3(10, 20, 3));
  CHECK(placement(mesh.vertices, mesh.triangles, {.rotate = "auto"}).linear() == Mat3::Identity());
}

TEST_CASE("a search tells what it found, and its first rotation can be written instead") {
  const TriMesh mesh =
      turned(box(Vec3(10, 20, 3)), Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  for (const char* rotate : {"auto", "flat"}) {
    std::vector<Orientation> found;
    const Eigen::Affine3d t = placement(mesh.vertices, mesh.triangles, {.rotate = rotate}, &found);
    REQUIRE(!found.empty());
    const Eigen::Affine3d written =
        placement(mesh.vertices, mesh.triangles, {.rotate = found.front().rotate}, &found);
    CHECK(t.matrix() == written.matrix());
    CHECK(found.empty());
  }
}

TEST_CASE("nothing flat, nothing to lay down") {
  Points p(3, 3);
  p << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  const Triangles none(0, 3);
  try {
    placement(p, none, {.rotate = "flat"});
    FAIL("no error");
  } catch (const Error& error) {
    CHECK(error.code == "mesh.no_flat_face");
  }
}
