#include "mesh/validate.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "base/error.h"
#include "grid_mesh.h"

using namespace s3;

namespace {

// The surface of a box with its corner at `at`, without the grid's inner vertices.
TriMesh box(const Vec3& size, const Vec3& at = Vec3::Zero(), int n = 1) {
  TriMesh mesh = boundary_surface(test::make_grid(n, n, n, size));
  mesh.vertices.rowwise() += at.transpose();
  clean_surface(mesh);
  return mesh;
}

TriMesh joined(const TriMesh& a, const TriMesh& b) {
  TriMesh both;
  both.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  both.vertices << a.vertices, b.vertices;
  both.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  both.triangles << a.triangles,
      (b.triangles.array() + static_cast<Index>(a.vertices.rows())).matrix();
  return both;
}

TriMesh turned_inside_out(TriMesh mesh) {
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

std::string code_of(const TriMesh& mesh) {
  try {
    require_valid_surface(inspect_surface(mesh));
  } catch (const Error& e) {
    CHECK(e.kind == ErrorKind::input);
    CHECK(!e.hint.empty());
    return e.code;
  }
  return "";
}

}  // namespace

TEST_CASE("a box is a valid solid with the right measures") {
  const MeshReport report = inspect_surface(box(Vec3(2, 3, 4), Vec3(5, 6, 7), 3));
  CHECK(report.valid());
  CHECK(report.volume == doctest::Approx(24));
  CHECK(report.area == doctest::Approx(52));
  CHECK((report.box.max - Vec3(7, 9, 11)).norm() < 1e-12);
  REQUIRE(report.shells.size() == 1);
  CHECK(report.shells[0].volume == doctest::Approx(24));
  CHECK(report.shells[0].depth == 0);
  CHECK(report.unused_vertices == 0);
  require_valid_surface(report);
}

TEST_CASE("a missing triangle leaves three open edges, and the error says where") {
  TriMesh mesh = box(Vec3(10, 10, 10), Vec3(100, 0, 0));
  mesh.triangles.conservativeResize(mesh.triangles.rows() - 1, 3);
  const MeshReport report = inspect_surface(mesh);
  CHECK(report.open_edges.count == 3);
  try {
    require_valid_surface(report);
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.code == "mesh.open_boundary");
    CHECK(std::string(e.what()).find("3 open edges near (1") != std::string::npos);
    CHECK(e.where.size() == 3);
  }
}

TEST_CASE("a flipped triangle disagrees with its three neighbours") {
  TriMesh mesh = box(Vec3(1, 1, 1), Vec3::Zero(), 2);
  std::swap(mesh.triangles(5, 0), mesh.triangles(5, 1));
  CHECK(inspect_surface(mesh).inconsistent_edges.count == 3);
  CHECK(code_of(mesh) == "mesh.inconsistent_orientation");
}

TEST_CASE("duplicate and degenerate triangles are counted") {
  TriMesh mesh = box(Vec3(1, 1, 1));
  mesh.triangles.conservativeResize(mesh.triangles.rows() + 2, 3);
  mesh.triangles.bottomRows(2) << mesh.triangles.topRows(1), 0, 0, 1;
  const MeshReport report = inspect_surface(mesh);
  CHECK(report.duplicate_triangles.count == 1);
  CHECK(report.degenerate_triangles.count == 1);
  CHECK(report.nonmanifold_edges.count == 3);
  CHECK(clean_surface(mesh).size() == 1);
  CHECK(inspect_surface(mesh).degenerate_triangles.count == 0);

  // Three corners on a line: (0,0,0) (1,1,0) (2,2,0).
  TriMesh flat;
  flat.vertices.resize(3, 3);
  flat.vertices << 0, 0, 0, 1, 1, 0, 2, 2, 0;
  flat.triangles.resize(1, 3);
  flat.triangles << 0, 1, 2;
  CHECK(inspect_surface(flat).degenerate_triangles.count == 1);
}

TEST_CASE("boxes that touch in a vertex or an edge are not manifold") {
  const TriMesh a = box(Vec3(1, 1, 1));
  const auto touching = [&](const Vec3& at) {
    TriMesh mesh = joined(a, box(Vec3(1, 1, 1), at));
    for (Index i = 0; i < a.vertices.rows(); ++i)
      for (Index j = static_cast<Index>(a.vertices.rows()); j < mesh.vertices.rows(); ++j)
        if (mesh.vertices.row(i) == mesh.vertices.row(j))
          mesh.triangles = mesh.triangles.unaryExpr([&](Index v) { return v == j ? i : v; }).eval();
    return mesh;
  };
  CHECK(inspect_surface(touching(Vec3(1, 1, 1))).nonmanifold_vertices.count == 1);
  CHECK(code_of(touching(Vec3(1, 1, 1))) == "mesh.non_manifold");
  CHECK(inspect_surface(touching(Vec3(1, 1, 0))).nonmanifold_edges.count == 1);
  CHECK(code_of(touching(Vec3(1, 1, 0))) == "mesh.non_manifold");
  CHECK(inspect_surface(touching(Vec3(3, 0, 0))).valid());
}

TEST_CASE("boxes that overlap, or touch face to face, intersect") {
  const TriMesh a = box(Vec3(2, 2, 2), Vec3::Zero(), 2);
  for (const Vec3& at :
       {Vec3(1.5, 1.3, 1.1), Vec3(2, 0.3, 0.4), Vec3(2, 2, 2), Vec3(0.5, 0.5, 2)}) {
    CAPTURE(at.transpose());
    const MeshReport report = inspect_surface(joined(a, box(Vec3(2, 2, 2), at)));
    CHECK(report.self_intersections.count > 0);
    CHECK(report.intersecting_pairs.size() ==
          static_cast<std::size_t>(report.self_intersections.count));
    CHECK(code_of(joined(a, box(Vec3(2, 2, 2), at))) == "mesh.self_intersection");
  }
  for (const double gap : {1e-12, 1e-3})
    CHECK(inspect_surface(joined(a, box(Vec3(2, 2, 2), Vec3(2 + gap, 0, 0)))).valid());
}

TEST_CASE("a cavity is a shell inside that faces inward, a body inside a body is an error") {
  const TriMesh outer = box(Vec3(10, 10, 10)), inner = box(Vec3(2, 2, 2), Vec3(4, 4, 4));
  const MeshReport hollow = inspect_surface(joined(outer, turned_inside_out(inner)));
  CHECK(hollow.valid());
  CHECK(hollow.volume == doctest::Approx(992));
  REQUIRE(hollow.shells.size() == 2);
  CHECK(hollow.shells[0].depth == 0);
  CHECK(hollow.shells[1].depth == 1);
  CHECK(hollow.shells[1].volume == doctest::Approx(-8));
  CHECK(code_of(joined(outer, inner)) == "mesh.inverted");
  CHECK(code_of(joined(inner, outer)) == "mesh.inverted");
}

TEST_CASE("a surface that is inside out is turned, cavities with it") {
  const TriMesh outer = box(Vec3(10, 10, 10)), inner = box(Vec3(2, 2, 2), Vec3(4, 4, 4));
  CHECK(code_of(turned_inside_out(outer)) == "mesh.inverted");
  for (TriMesh mesh :
       {turned_inside_out(outer), turned_inside_out(joined(outer, turned_inside_out(inner))),
        joined(outer, turned_inside_out(box(Vec3(1, 1, 1), Vec3(20, 0, 0))))}) {
    CHECK(clean_surface(mesh).size() == 1);
    CHECK(code_of(mesh) == "");
    CHECK(inspect_surface(mesh).volume > 900);
  }
}

TEST_CASE("cleaning joins equal vertices where that closes the surface and drops unused ones") {
  const TriMesh solid = box(Vec3(1, 2, 3), Vec3::Zero(), 2);
  TriMesh soup;
  soup.vertices.resize(3 * solid.triangles.rows() + 1, 3);
  soup.triangles.resize(solid.triangles.rows(), 3);
  for (Eigen::Index f = 0; f < solid.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      soup.vertices.row(3 * f + i) = solid.vertices.row(solid.triangles(f, i));
      soup.triangles(f, i) = static_cast<Index>(3 * f + i);
    }
  soup.vertices.bottomRows(1) << 9, 9, 9;
  CHECK(inspect_surface(soup).unused_vertices == 1);
  CHECK(clean_surface(soup).size() == 2);
  CHECK(soup.vertices.rows() == solid.vertices.rows());
  CHECK(inspect_surface(soup).valid());

  // Two closed boxes that share a place but no vertices stay two boxes.
  TriMesh two = joined(solid, box(Vec3(1, 2, 3), Vec3(1, 2, 3)));
  CHECK(clean_surface(two).empty());
}

TEST_CASE("an empty surface and a doubtful size are reported") {
  CHECK(code_of(TriMesh{}) == "mesh.empty");
  Context ctx;
  warn_about_units({Vec3::Zero(), Vec3(100, 50, 1e-3)}, ctx);
  CHECK(ctx.warnings.empty());
  warn_about_units({Vec3::Zero(), Vec3(0.9, 0.1, 0.1)}, ctx);
  warn_about_units({Vec3::Zero(), Vec3(0.9, 2001, 0.1)}, ctx);
  REQUIRE(ctx.warnings.size() == 2);
  CHECK(ctx.warnings[0].code == "mesh.units");
}

TEST_CASE("shells that touch are not inside each other") {
  // Two tetrahedra with a common edge; a corner of each lies on the other's surface.
  TriMesh mesh;
  mesh.vertices.resize(8, 3);
  mesh.vertices << 0, 0, 13, 2, 13, 6, 8, 0, 0, 0, 8, 0, 1, 1, 1, 1, 6, 1, 0, 0, 13, 8, 0, 0;
  mesh.triangles.resize(8, 3);
  mesh.triangles << 0, 1, 2, 0, 3, 1, 6, 7, 4, 1, 3, 2, 7, 6, 5, 2, 3, 0, 6, 4, 5, 5, 4, 7;
  for (const Shell& shell : measure_shells(mesh).shells) CHECK(shell.depth == 0);
}
