#include "mesh/refine_surface.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "grid_mesh.h"
#include "mesh/aabb_tree.h"
#include "mesh/placement.h"
#include "mesh/validate.h"

using namespace s3;

namespace {

TriMesh box(const Vec3& size) {
  return boundary_surface(test::make_grid(1, 1, 1, size));
}

// A cylinder of n sides with caps as fans from one corner of their rims: needles, as CAD programs
// write them.
TriMesh needle_cylinder(int n, double radius, double height) {
  TriMesh mesh;
  mesh.vertices.resize(2 * n, 3);
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * kPi * i / n;
    mesh.vertices.row(i) << radius * std::cos(angle), radius * std::sin(angle), 0;
    mesh.vertices.row(n + i) << radius * std::cos(angle), radius * std::sin(angle), height;
  }
  mesh.triangles.resize(4 * n - 4, 3);
  Eigen::Index f = 0;
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.row(f++) << i, j, n + j;
    mesh.triangles.row(f++) << i, n + j, n + i;
  }
  for (int i = 1; i + 1 < n; ++i) {
    mesh.triangles.row(f++) << 0, i + 1, i;
    mesh.triangles.row(f++) << n, n + i, n + i + 1;
  }
  return mesh;
}

double longest_edge(const TriMesh& mesh) {
  double longest = 0;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i)
      longest = std::max(longest, (mesh.vertices.row(mesh.triangles(f, i)) -
                                   mesh.vertices.row(mesh.triangles(f, (i + 1) % 3)))
                                      .norm());
  return longest;
}

double smallest_angle_deg(const TriMesh& mesh) {
  double smallest = 180;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = mesh.vertices.row(mesh.triangles(f, i)),
                 b = mesh.vertices.row(mesh.triangles(f, (i + 1) % 3)),
                 c = mesh.vertices.row(mesh.triangles(f, (i + 2) % 3));
      smallest =
          std::min(smallest, degrees(std::atan2((b - a).cross(c - a).norm(), (b - a).dot(c - a))));
    }
  return smallest;
}

void check_same_shape(const TriMesh& coarse, const TriMesh& fine, double target) {
  CHECK(longest_edge(fine) <= 4.0 / 3 * target * (1 + 1e-12));
  CHECK(surface_area(fine) == doctest::Approx(surface_area(coarse)).epsilon(1e-9));
  CHECK(enclosed_volume(fine) == doctest::Approx(enclosed_volume(coarse)).epsilon(1e-9));
  CHECK(fine.vertices.topRows(coarse.vertices.rows()) == coarse.vertices);
  const MeshReport report = inspect_surface(fine);
  CHECK(report.open_edges.count == 0);
  CHECK(report.nonmanifold_edges.count == 0);
  CHECK(report.nonmanifold_vertices.count == 0);
  CHECK(report.inconsistent_edges.count == 0);
  CHECK(report.self_intersections.count == 0);
  const AabbTree tree(coarse);
  double farthest = 0;
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v)
    farthest = std::max(farthest, tree.closest(fine.vertices.row(v)).distance);
  CHECK(farthest < 1e-9 * bounding_box(coarse.vertices).diagonal());
}

}  // namespace

TEST_CASE("two triangles a side become small even ones") {
  const TriMesh coarse = box(Vec3(10, 20, 5));
  for (const double target : {100.0, 3.0, 1.0}) {
    CAPTURE(target);
    const TriMesh fine = refine_surface(coarse, target);
    check_same_shape(coarse, fine, target);
    if (target > 50) CHECK(fine.triangles.rows() == coarse.triangles.rows());
    if (target == 1.0) {
      const double even = surface_area(coarse) / (std::sqrt(3.0) / 4);
      CHECK(static_cast<double>(fine.triangles.rows()) > 0.8 * even);
      CHECK(static_cast<double>(fine.triangles.rows()) < 2.5 * even);
      CHECK(smallest_angle_deg(fine) > 25);
    }
  }
}

TEST_CASE("fans of needles become even triangles, also on a slanted plane") {
  TriMesh coarse = needle_cylinder(120, 10, 30);
  CHECK(smallest_angle_deg(coarse) < 2);
  transform_points(Eigen::Affine3d(Eigen::AngleAxisd(0.9, Vec3(1, 2, 3).normalized())),
                   coarse.vertices);
  const TriMesh fine = refine_surface(coarse, 1.0);
  check_same_shape(coarse, fine, 1.0);
  CHECK(smallest_angle_deg(fine) > 9);  // strips of 0.5 mm with splits at different heights
}

TEST_CASE("edges between slanted faces are never flipped away") {
  // A sharp wedge: every pair of its sides meets at an angle, so that flips would cut it.
  const TriMesh coarse =
      boundary_surface(test::make_grid(1, 1, 1, Vec3(4, 30, 4), [](const Vec3& p) {
        return Vec3(p.x() * (1 - p.y() / 40) + 0.2 * p.y(), p.y(),
                    p.z() * (1 + p.x() * p.y() / 500));
      }));
  check_same_shape(coarse, refine_surface(coarse, 0.8), 0.8);
}

TEST_CASE("refinement takes near-linear time and refuses the impossible") {
  const TriMesh coarse = box(Vec3(100, 100, 100));
  CHECK(refine_surface(coarse, 1.0).triangles.rows() > 100000);
  CHECK_THROWS_AS(refine_surface(coarse, 0.01), Error);
  CHECK_THROWS_AS(refine_surface(coarse, 0), Error);
  TriMesh doubled = coarse;
  doubled.triangles.conservativeResize(doubled.triangles.rows() + 1, 3);
  doubled.triangles.bottomRows(1) = doubled.triangles.topRows(1);
  CHECK_THROWS_AS(refine_surface(doubled, 10), Error);
}

TEST_CASE("the target edge fills the volume with the asked number of regular tets") {
  const double edge = target_edge_for(box(Vec3(10, 10, 10)), 1000);
  CHECK(edge * edge * edge / (6 * std::sqrt(2.0)) == doctest::Approx(1.0));
  TriMesh inverted = box(Vec3(1, 1, 1));
  inverted.triangles.col(0).swap(inverted.triangles.col(1));
  CHECK_THROWS_AS(target_edge_for(inverted, 1000), Error);
}
