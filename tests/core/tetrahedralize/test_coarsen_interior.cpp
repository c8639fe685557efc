#include "tetrahedralize/coarsen_interior.h"

#include <algorithm>
#include <array>
#include <vector>

#include <doctest/doctest.h>

#include "base/units.h"
#include "grid_mesh.h"
#include "test_shapes.h"
#include "tetrahedralize/isosurface_stuffing.h"
#include "tetrahedralize/quality.h"

using namespace s3;
using namespace s3::test;

namespace {

// Coordinates of the corners of boundary faces, sorted: the same for meshes with the same boundary.
std::vector<std::array<double, 9>> boundary_of(const TetMesh& mesh) {
  std::vector<std::array<double, 9>> faces;
  for (Eigen::Index f = 0; f < mesh.boundary_faces.rows(); ++f) {
    std::array<std::array<double, 3>, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const Index v = mesh.boundary_faces(f, static_cast<Eigen::Index>(i));
      corners[i] = {mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2)};
    }
    std::sort(corners.begin(), corners.end());
    std::array<double, 9> face;
    for (std::size_t i = 0; i < 9; ++i) face[i] = corners[i / 3][i % 3];
    faces.push_back(face);
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

}  // namespace

TEST_CASE("coarsening the inside keeps boundary, volume and angles, and comes to the target") {
  const Context ctx;
  const TetMesh fine = make_grid(16, 16, 16, Vec3(16, 16, 16));
  for (const double share : {0.9, 0.7}) {
    TetMesh mesh = fine;
    const auto target = static_cast<Index>(share * fine.tet_count());
    coarsen_interior(mesh, target, ctx);
    CHECK(mesh.tet_count() <= target);
    CHECK(mesh.tet_count() > target - 50);  // what one vertex takes with it
    CHECK(boundary_of(mesh) == boundary_of(fine));
    CHECK(tet_volumes(mesh).sum() == doctest::Approx(tet_volumes(fine).sum()).epsilon(1e-12));
    const TetQuality quality = tet_quality(mesh);
    CHECK(degrees(quality.min_dihedral) > 14.99);
    CHECK(degrees(quality.max_dihedral) < 165.01);
  }
}

TEST_CASE("a mesh within the target is left alone, and one without an inside as well") {
  const Context ctx;
  TetMesh mesh = make_grid(16, 16, 16, Vec3(16, 16, 16));
  const Tets tets = mesh.tets;
  coarsen_interior(mesh, mesh.tet_count(), ctx);
  CHECK(mesh.tets == tets);
  TetMesh thin = make_grid(20, 20, 2, Vec3(20, 20, 2));
  const Index before = thin.tet_count();
  coarsen_interior(thin, 10, ctx);
  CHECK(thin.tet_count() == before);
}

TEST_CASE("stuffed tets are larger inside than along the surface") {
  Context ctx;
  const TetMesh mesh = fill_by_stuffing(sphere(10, 12), 20000, ctx);
  CHECK(mesh.tet_count() < 1.1 * 20000);
  const Values volumes = tet_volumes(mesh);
  double inner = 0, outer = 0, inner_tets = 0, outer_tets = 0;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    const double depth = 10 - mesh.centroid(t).norm();
    if (depth > 4) {
      inner += volumes[t];
      ++inner_tets;
    } else if (depth < 1) {
      outer += volumes[t];
      ++outer_tets;
    }
  }
  CHECK(inner / inner_tets > 1.5 * outer / outer_tets);
}
