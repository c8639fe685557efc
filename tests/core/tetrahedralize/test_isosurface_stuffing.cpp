#include "tetrahedralize/isosurface_stuffing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "base/units.h"
#include "mesh/surface_distance.h"
#include "mesh/validate.h"
#include "test_shapes.h"
#include "tetrahedralize/boundary_check.h"
#include "tetrahedralize/quality.h"
#include "tetrahedralize/tetrahedralize.h"

using namespace s3;
using namespace s3::test;

namespace {

TetMesh stuff(const TriMesh& surface, int target, std::vector<Warning>* warnings = nullptr) {
  Context ctx;
  TetMesh mesh = fill_by_stuffing(surface, target, ctx);
  if (warnings) *warnings = ctx.warnings;
  return mesh;
}

// What every mesh must be, whatever the surface. @return the boundary
TriMesh check_sound(const TetMesh& mesh, int target, double least_angle_deg) {
  CHECK(mesh.tet_count() > 0.85 * target);
  CHECK(mesh.tet_count() < 1.15 * target);
  CHECK(tet_volumes(mesh).minCoeff() > 0);
  const TetQuality quality = tet_quality(mesh);
  CHECK(degrees(quality.min_dihedral) > least_angle_deg);
  CHECK(degrees(quality.max_dihedral) < 180 - least_angle_deg);
  TriMesh boundary = boundary_surface(mesh);
  const MeshReport report = inspect_surface(boundary);
  CHECK(report.open_edges.count == 0);
  CHECK(report.nonmanifold_edges.count == 0);
  CHECK(report.nonmanifold_vertices.count == 0);
  CHECK(report.inconsistent_edges.count == 0);
  CHECK(report.self_intersections.count == 0);
  CHECK(report.inverted_shells() == 0);
  return boundary;
}

double volume_of(const TetMesh& mesh) {
  return tet_volumes(mesh).sum();
}

double p95_share(const TriMesh& boundary, const TriMesh& surface) {
  Context ctx;
  const WindingNumber solid(surface);
  return surface_distance(boundary, surface, &solid, ctx, 5000).p95() /
         bounding_box(surface.vertices).diagonal();
}

// Twelve triangles without common vertices and in no order, as a poor program writes them.
TriMesh shattered(const TriMesh& mesh) {
  const Eigen::Index n = mesh.triangles.rows();
  TriMesh soup{Points(3 * n, 3), Triangles(n, 3)};
  for (Eigen::Index f = 0; f < n; ++f)
    for (int i = 0; i < 3; ++i) {
      const auto v = static_cast<Index>(3 * f + i);
      soup.vertices.row(v) = mesh.vertices.row(mesh.triangles((7 * f) % n, i));
      soup.triangles(f, i) = v;
    }
  return soup;
}

// The sphere without the triangles over a height.
TriMesh without_cap(const TriMesh& ball, double height) {
  Triangles low_triangles(ball.triangles.rows(), 3);
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < ball.triangles.rows(); ++f) {
    double low = ball.vertices(ball.triangles(f, 0), 2);
    for (int i = 1; i < 3; ++i) low = std::min(low, ball.vertices(ball.triangles(f, i), 2));
    if (low <= height) low_triangles.row(kept++) = ball.triangles.row(f);
  }
  return {ball.vertices, low_triangles.topRows(kept)};
}

}  // namespace

TEST_CASE("stuffing fills a sphere with its volume and well-shaped tets") {
  const TriMesh ball = sphere(10, 24);
  const TetMesh mesh = stuff(ball, 15000);
  const TriMesh boundary = check_sound(mesh, 15000, 10);
  CHECK(volume_of(mesh) == doctest::Approx(4.0 / 3 * kPi * 1000).epsilon(0.015));
  CHECK(p95_share(boundary, ball) < 0.003);
}

TEST_CASE("stuffing keeps the edges and corners of a cube") {
  for (const Vec3& turn : {Vec3(0, 0, 0), Vec3(0.3, 0.5, 0.2)}) {
    TriMesh box = cube(10);
    const Mat3 rotation =
        (Eigen::AngleAxisd(turn[0], Vec3::UnitX()) * Eigen::AngleAxisd(turn[1], Vec3::UnitY()) *
         Eigen::AngleAxisd(turn[2], Vec3::UnitZ()))
            .toRotationMatrix();
    box.vertices = (box.vertices * rotation.transpose()).eval();
    const TetMesh mesh = stuff(box, 10000);
    const TriMesh boundary = check_sound(mesh, 10000, 10);
    CHECK(volume_of(mesh) == doctest::Approx(1000).epsilon(0.002));
    CHECK(p95_share(boundary, box) < 1e-4);
    for (Eigen::Index corner = 0; corner < 8; ++corner)
      CHECK((boundary.vertices.rowwise() - box.vertices.row(corner)).rowwise().norm().minCoeff() <
            1e-6);
  }
}

TEST_CASE("stuffing keeps the hole of a torus open") {
  const TriMesh ring = torus(20, 6, 80, 24);
  const TetMesh mesh = stuff(ring, 15000);
  const TriMesh boundary = check_sound(mesh, 15000, 8);
  CHECK(volume_of(mesh) == doctest::Approx(enclosed_volume(ring)).epsilon(0.015));
  // Euler: V − E + F = 0, where 2 E = 3 F.
  std::vector<char> used(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (Eigen::Index i = 0; i < boundary.triangles.size(); ++i)
    used[static_cast<std::size_t>(boundary.triangles.data()[i])] = 1;
  CHECK(2 * std::count(used.begin(), used.end(), 1) == boundary.triangles.rows());
}

TEST_CASE("stuffing fills overlapping bodies once and ignores the faces inside") {
  const TriMesh ball = sphere(10, 20), both = join(ball, moved(ball, Vec3(12, 0, 0)));
  const TetMesh mesh = stuff(both, 15000);
  const TriMesh boundary = check_sound(mesh, 15000, 8);
  // Two balls less their lens: π (4 r + d)(2 r − d)²/12.
  const double lens = kPi * (40 + 12) * (20 - 12) * (20 - 12) / 12;
  CHECK(volume_of(mesh) == doctest::Approx(2 * 4.0 / 3 * kPi * 1000 - lens).epsilon(0.015));
  CHECK(inspect_surface(boundary).shells.size() == 1);
  CHECK(p95_share(boundary, both) < 0.004);
}

TEST_CASE("stuffing closes a hole with a smooth sheet") {
  const TriMesh ball = sphere(10, 24);
  const TetMesh mesh = stuff(without_cap(ball, 8), 10000);
  check_sound(mesh, 10000, 8);
  // Between the ball without and with its cap of height 2: π h² (3 r − h)/3.
  const double full = 4.0 / 3 * kPi * 1000, cap = kPi * 4 * 28 / 3;
  CHECK(volume_of(mesh) > 0.985 * (full - cap));
  CHECK(volume_of(mesh) < full);
}

TEST_CASE("stuffing leaves cavities empty") {
  const TriMesh hollow = join(sphere(15, 20), inverted(sphere(9, 16)));
  const TetMesh mesh = stuff(hollow, 20000);
  const TriMesh boundary = check_sound(mesh, 20000, 8);
  CHECK(inspect_surface(boundary).shells.size() == 2);
  CHECK(volume_of(mesh) == doctest::Approx(enclosed_volume(hollow)).epsilon(0.02));
}

TEST_CASE("stuffing takes triangles without common vertices") {
  const TetMesh whole = stuff(cube(10), 3000), soup = stuff(shattered(cube(10)), 3000);
  check_sound(soup, 3000, 8);
  CHECK(volume_of(soup) == doctest::Approx(1000).epsilon(0.005));
  CHECK(soup.tet_count() == whole.tet_count());
}

TEST_CASE("balls that nearly touch, touch, or barely overlap still give a manifold") {
  for (const double distance : {20.2, 20.0, 19.9, 19.5, 19.0}) {
    CAPTURE(distance);
    const TriMesh ball = sphere(10, 16);
    check_sound(stuff(join(ball, moved(ball, Vec3(distance, 0.3, 0.1))), 6000), 6000, 4);
  }
}

TEST_CASE("stuffing gives the same tets for any number of threads, and again") {
  const TriMesh ring = torus(20, 6, 60, 20);
  Context one(1), three(3);
  const TetMesh a = fill_by_stuffing(ring, 8000, one), b = fill_by_stuffing(ring, 8000, three);
  CHECK(a.vertices == b.vertices);
  CHECK(a.tets == b.tets);
}

TEST_CASE("native and WebAssembly builds stuff the same tets") {
  // The cube's coordinates are exact, so that no library function of the platform takes part in the
  // input.
  const TetMesh mesh = stuff(join(cube(16), moved(cube(8), Vec3(12.25, 4.5, 3.125))), 4000);
  std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a over corners and coordinates
  const auto add = [&](std::uint64_t x) { hash = (hash ^ x) * 1099511628211ULL; };
  for (Eigen::Index i = 0; i < mesh.tets.size(); ++i)
    add(static_cast<std::uint64_t>(mesh.tets.data()[i]));
  for (Eigen::Index i = 0; i < mesh.vertices.size(); ++i)
    add(static_cast<std::uint64_t>(std::llround(1e6 * mesh.vertices.data()[i])));
  CHECK(mesh.tet_count() == 3995);
  CHECK(hash == 17204756092703496373ULL);
}

TEST_CASE("walls that the lattice cannot hold are reported with the share that is left") {
  // Five sheets of 0.2 mm, 4 mm apart.
  TriMesh sheet = cube(20);
  sheet.vertices.col(2) *= 0.01;
  TriMesh sheets = sheet;
  for (int i = 1; i < 5; ++i) sheets = join(sheets, moved(sheet, Vec3(0, 0, 4.1 * i)));
  sheets = join(sheets, moved(cube(10), Vec3(30, 0, 0)));
  std::vector<Warning> warnings;
  stuff(sheets, 3000, &warnings);
  CHECK(std::any_of(warnings.begin(), warnings.end(), [](const Warning& w) {
    return w.code == "tetrahedralize.unresolved" && w.message.find('%') != std::string::npos;
  }));
}

TEST_CASE("a surface that winds around nothing is refused with a sentence") {
  const auto code_of = [](const TriMesh& surface) {
    Context ctx;
    try {
      fill_by_stuffing(surface, 3000, ctx);
    } catch (const Error& error) {
      CHECK(!error.hint.empty());
      return error.code;
    }
    return std::string("none");
  };
  CHECK(code_of(inverted(cube(10))) == "tetrahedralize.empty");
  TriMesh sheet = cube(10);
  sheet.triangles.conservativeResize(2, 3);
  CHECK(code_of(sheet) == "tetrahedralize.empty");
}

TEST_CASE("auto fills by stuffing what has a defect or makes TetGen fail, and says why") {
  const TriMesh crossing = join(cube(10), moved(cube(10), Vec3(5, 4, 3)));
  for (const std::string defect : {"", "Two bodies cross"}) {
    Context ctx;
    const Tetrahedralization result =
        tetrahedralize(crossing, {.target_tets = 6000, .backend = "auto"}, ctx, defect);
    CHECK(result.backend == "stuffing");
    CHECK(!result.fallback.empty());
    CHECK(volume_of(result.mesh) == doctest::Approx(2000 - 5 * 6 * 7).epsilon(0.01));
    REQUIRE(!ctx.warnings.empty());
    CHECK(ctx.warnings[0].code == "tetrahedralize.stuffed");
    if (!defect.empty()) CHECK(ctx.warnings[0].message.find(defect) != std::string::npos);
  }
  Context ctx;
  CHECK(tetrahedralize(cube(10), {.target_tets = 2000, .backend = "stuffing"}, ctx).backend ==
        "stuffing");
  CHECK(ctx.warnings.empty());
}

TEST_CASE("a cancel stops the stuffing") {
  Context ctx;
  ctx.cancel_requested = true;
  CHECK_THROWS_AS(fill_by_stuffing(cube(10), 3000, ctx), Cancelled);
}

TEST_CASE("the check of the boundary finds a common edge and a common vertex") {
  Points vertices(8, 3);
  vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, -1, -1, 0, -1, -1, -1;
  Tets edge(2, 4), vertex(2, 4), one(1, 4);
  one << 0, 1, 2, 3;
  edge << 0, 1, 2, 3, 0, 1, 4, 5;    // share the edge 0–1
  vertex << 0, 1, 2, 3, 0, 4, 6, 7;  // share the vertex 0
  CHECK(nonmanifold_boundary_vertices(make_tet_mesh(vertices, one)).empty());
  CHECK(nonmanifold_boundary_vertices(make_tet_mesh(vertices, edge)) == std::vector<Index>{0, 1});
  CHECK(nonmanifold_boundary_vertices(make_tet_mesh(vertices, vertex)) == std::vector<Index>{0});
}
