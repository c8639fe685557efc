#include "tetrahedralize/coarsen_surface.h"

#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "base/units.h"
#include "mesh/refine_surface.h"
#include "mesh/surface_distance.h"
#include "mesh/validate.h"
#include "test_shapes.h"
#include "tetrahedralize/fill_solid.h"
#include "tetrahedralize/quality.h"

using namespace s3;
using namespace s3::test;

namespace {

// A round bar with n facets, lids as fans of needles from one vertex.
TriMesh bar(double radius, double height, int n) {
  TriMesh mesh{Points(2 * n, 3), Triangles(4 * n - 4, 3)};
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * kPi * i / n;
    mesh.vertices.row(i) << radius * std::cos(angle), radius * std::sin(angle), 0;
    mesh.vertices.row(n + i) << radius * std::cos(angle), radius * std::sin(angle), height;
    const int j = (i + 1) % n;
    mesh.triangles.row(2 * i) << i, j, n + j;
    mesh.triangles.row(2 * i + 1) << i, n + j, n + i;
  }
  for (int i = 1; i < n - 1; ++i) {
    mesh.triangles.row(2 * n + i - 1) << 0, i + 1, i;
    mesh.triangles.row(3 * n - 2 + i - 1) << n, n + i, n + i + 1;
  }
  return mesh;
}

// A cube with a vertex cut off in a needle: two corners of its top a hair apart.
TriMesh cube_with_needle(double size, double hair) {
  TriMesh mesh = cube(size);
  // The vertex of the first triangle's first edge is doubled along that edge.
  const Index a = mesh.triangles(0, 0), b = mesh.triangles(0, 1);
  const Vec3 p = mesh.vertices.row(a), q = mesh.vertices.row(b);
  mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
  const auto m = static_cast<Index>(mesh.vertices.rows() - 1);
  mesh.vertices.row(m) = p + hair * (q - p).normalized();
  const Eigen::Index n = mesh.triangles.rows();
  for (Eigen::Index f = 0; f < n; ++f)
    for (int i = 0; i < 3; ++i) {
      const Index u = mesh.triangles(f, i), v = mesh.triangles(f, (i + 1) % 3),
                  w = mesh.triangles(f, (i + 2) % 3);
      if (!((u == a && v == b) || (u == b && v == a))) continue;
      mesh.triangles.row(f) << u, m, w;
      mesh.triangles.conservativeResize(mesh.triangles.rows() + 1, 3);
      mesh.triangles.row(mesh.triangles.rows() - 1) << m, v, w;
      break;
    }
  return mesh;
}

double farthest(const TriMesh& made, const TriMesh& given) {
  Context ctx;
  return surface_distance(made, given, nullptr, ctx).max();
}

}  // namespace

TEST_CASE("a sphere loses the triangles that a tolerance allows, and no more") {
  const Context ctx;
  const TriMesh fine = sphere(10, 40);  // edges of about 0.39 mm
  Eigen::Index last = fine.triangles.rows();
  for (const double tolerance : {0.02, 0.08}) {
    const TriMesh coarse = coarsen_surface(fine, 4, tolerance, ctx);
    CHECK(inspect_surface(coarse).valid());
    CHECK(farthest(coarse, fine) < 1.5 * tolerance);
    CHECK(std::abs(enclosed_volume(coarse) / enclosed_volume(fine) - 1) < 3 * tolerance / 10);
    // Triangles that cut off s have edges of about √(8 R s).
    const double edge = std::sqrt(8 * 10 * tolerance);
    const double fitting = surface_area(fine) / (0.433 * edge * edge);
    CHECK(coarse.triangles.rows() < 6 * fitting + 500);
    CHECK(coarse.triangles.rows() < 0.6 * static_cast<double>(last));
    last = coarse.triangles.rows();
  }
}

TEST_CASE("edges longer than the wanted one are left alone, and so is their number") {
  const Context ctx;
  const TriMesh even = sphere(10, 8);
  CHECK(coarsen_surface(even, 1.2, 1, ctx).triangles == even.triangles);
}

TEST_CASE("a finely split cube becomes coarse and keeps its form exactly") {
  const Context ctx;
  const TriMesh coarse = coarsen_surface(refine_surface(cube(20), 0.7), 5, 0.25, ctx);
  CHECK(inspect_surface(coarse).valid());
  CHECK(coarse.triangles.rows() < 1500);
  CHECK(enclosed_volume(coarse) == doctest::Approx(8000).epsilon(1e-12));
  CHECK(surface_area(coarse) == doctest::Approx(2400).epsilon(1e-12));
}

TEST_CASE("an edge that no tet could use is contracted even at a corner") {
  const Context ctx;
  const TriMesh needle = cube_with_needle(20, 1e-3);
  REQUIRE(inspect_surface(needle).valid());
  REQUIRE(needle.triangles.rows() == 14);
  const TriMesh mended = coarsen_surface(needle, 2, 0.02, ctx);
  CHECK(inspect_surface(mended).valid());
  CHECK(mended.triangles.rows() == 12);
  CHECK(enclosed_volume(mended) == doctest::Approx(8000).epsilon(1e-4));
}

TEST_CASE("needles and caps are no reason for flat tets") {
  const struct {
    TriMesh surface;
    const char* name;
  } shapes[] = {{bar(10, 30, 240), "bar"}, {cube_with_needle(20, 1e-4), "cube"}};
  for (const auto& shape : shapes) {
    CAPTURE(shape.name);
    REQUIRE(inspect_surface(shape.surface).valid());
    Context ctx;
    const SolidFilling filling = fill_solid(shape.surface, 8000, ctx);
    CHECK(degrees(tet_quality(filling.mesh).min_dihedral) > 1);
    CHECK(filling.mesh.tet_count() > 0.8 * 8000);
    CHECK(filling.mesh.tet_count() < 1.2 * 8000);
    const double volume = enclosed_volume(shape.surface);
    CHECK(tet_volumes(filling.mesh).sum() == doctest::Approx(volume).epsilon(0.01));
    // 5 % of a tet's edge in each of two steps.
    const double edge = target_edge_for(shape.surface, 8000);
    CHECK(farthest(boundary_surface(filling.mesh), shape.surface) < 0.1 * edge);
    REQUIRE(ctx.warnings.size() == (filling.simplified ? 1 : 0));
    CHECK(filling.simplified);
    CHECK(ctx.warnings[0].code == "tetrahedralize.simplified");
  }
}

TEST_CASE("a surface that gives good tets is kept") {
  Context ctx;
  CHECK_FALSE(fill_solid(cube(20), 3000, ctx).simplified);
  CHECK(ctx.warnings.empty());
}
