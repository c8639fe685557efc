#include "tetrahedralize/tetrahedralize.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "base/units.h"
#include "test_shapes.h"
#include "tetrahedralize/quality.h"

using namespace s3;
using namespace s3::test;

namespace {

TetMesh fill(const TriMesh& surface, int target) {
  Context ctx;
  return tetrahedralize(surface, {.target_tets = target, .backend = "tetgen"}, ctx).mesh;
}

double total_volume(const TetMesh& mesh) {
  return tet_volumes(mesh).sum();
}

// Every edge of a boundary face belongs to two faces, once in each direction.
bool is_closed(const TetMesh& mesh) {
  std::vector<std::pair<Index, Index>> edges;
  for (Eigen::Index f = 0; f < mesh.boundary_faces.rows(); ++f)
    for (int i = 0; i < 3; ++i)
      edges.emplace_back(mesh.boundary_faces(f, i), mesh.boundary_faces(f, (i + 1) % 3));
  std::sort(edges.begin(), edges.end());
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    const auto range =
        std::equal_range(edges.begin(), edges.end(), std::pair(edge.second, edge.first));
    return range.second - range.first == 1;
  });
}

// Counts checkpoints and cancels at one of them.
struct CancelAt {
  explicit CancelAt(long n) {
    ctx.on_checkpoint = [this, n] { ctx.cancel_requested = ++count == n; };
  }
  Context ctx;
  long count = 0;
};

void check_count(const TetMesh& mesh, int target) {
  CHECK(mesh.tet_count() > 0.85 * target);
  CHECK(mesh.tet_count() < 1.15 * target);
}

}  // namespace

TEST_CASE("a cube is filled with the wanted number of well-shaped tets") {
  for (const int target : {3000, 20000}) {
    const TetMesh mesh = fill(cube(20), target);
    check_count(mesh, target);
    CHECK(total_volume(mesh) == doctest::Approx(8000).epsilon(1e-12));
    CHECK(enclosed_volume(boundary_surface(mesh)) == doctest::Approx(8000).epsilon(1e-12));
    CHECK(is_closed(mesh));
    const TetQuality quality = tet_quality(mesh);
    CHECK(degrees(quality.min_dihedral) > 8);
    CHECK(degrees(quality.max_dihedral) < 165);
  }
}

TEST_CASE("a finely meshed surface keeps its triangles") {
  const TriMesh surface = sphere(15, 20);
  const TetMesh mesh = fill(surface, 20000);
  check_count(mesh, 20000);
  CHECK(mesh.boundary_faces.rows() == surface.triangles.rows());
  CHECK(total_volume(mesh) == doctest::Approx(enclosed_volume(surface)).epsilon(1e-12));
  CHECK(is_closed(mesh));
  // What the kept triangles force: two of them that nearly share a plane can be faces of one flat
  // tet.
  const TetQuality quality = tet_quality(mesh);
  CHECK(quality.tets_below_10_deg < 0.005 * mesh.tet_count());
  CHECK(degrees(quality.min_dihedral) > 1);
}

TEST_CASE("the hole of a torus stays open") {
  const TriMesh surface = torus(20, 6, 80, 24);
  const TetMesh mesh = fill(surface, 15000);
  check_count(mesh, 15000);
  CHECK(total_volume(mesh) == doctest::Approx(enclosed_volume(surface)).epsilon(1e-12));
  CHECK(is_closed(mesh));
  // Euler: the boundary of a solid torus has V − E + F = 0, where 2 E = 3 F.
  std::vector<char> on_boundary(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (Eigen::Index i = 0; i < mesh.boundary_faces.size(); ++i)
    on_boundary[static_cast<std::size_t>(mesh.boundary_faces.data()[i])] = 1;
  CHECK(2 * std::count(on_boundary.begin(), on_boundary.end(), 1) == mesh.boundary_faces.rows());
}

TEST_CASE("two shells apart from each other are both filled") {
  const TriMesh surface = join(sphere(8, 10), moved(sphere(5, 8), Vec3(20, 0, 0)));
  const TetMesh mesh = fill(surface, 12000);
  check_count(mesh, 12000);
  CHECK(total_volume(mesh) == doctest::Approx(enclosed_volume(surface)).epsilon(1e-12));
  CHECK(is_closed(mesh));
}

TEST_CASE("a shell turned inside out is a cavity, and a shell inside the cavity is solid again") {
  const TriMesh hollow = join(sphere(15, 16), inverted(sphere(10, 12)));
  const TetMesh mesh = fill(hollow, 15000);
  check_count(mesh, 15000);
  CHECK(total_volume(mesh) == doctest::Approx(enclosed_volume(hollow)).epsilon(1e-12));
  CHECK(is_closed(mesh));

  const TriMesh with_core = join(hollow, sphere(5, 8));
  const TetMesh filled = fill(with_core, 15000);
  CHECK(total_volume(filled) == doctest::Approx(enclosed_volume(with_core)).epsilon(1e-12));
  CHECK(is_closed(filled));
}

TEST_CASE("the tet mesh does not depend on anything but its input") {
  const TriMesh surface = torus(20, 6, 60, 20);
  const TetMesh first = fill(surface, 8000);
  fill(cube(3), 1000);  // TetGen keeps static state between runs
  const TetMesh second = fill(surface, 8000);
  CHECK(first.vertices == second.vertices);
  CHECK(first.tets == second.tets);
}

TEST_CASE("native and WebAssembly builds make the same tets") {
  // The cube's coordinates are exact, so that no library function of the platform takes part in the
  // input.
  const TetMesh mesh = fill(cube(16), 3000);
  std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a over the tets' corners
  for (Eigen::Index i = 0; i < mesh.tets.size(); ++i)
    hash = (hash ^ static_cast<std::uint64_t>(mesh.tets.data()[i])) * 1099511628211ULL;
  CHECK(mesh.tet_count() == 2817);
  CHECK(hash == 11299256776090299255ULL);
}

TEST_CASE("a scaled surface gives the same tets, scaled") {
  const TriMesh surface = torus(20, 6, 60, 20);
  TriMesh large = surface;
  large.vertices *= 8;  // a power of two: no rounding
  const TetMesh first = fill(surface, 8000), second = fill(large, 8000);
  REQUIRE(first.tet_count() == second.tet_count());
  CHECK(first.tets == second.tets);
  CHECK((8 * first.vertices - second.vertices).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("surfaces that cross or overlap themselves are refused, not crashed on") {
  const auto code_of = [](const TriMesh& surface) {
    try {
      fill(surface, 3000);
    } catch (const Error& error) {
      CHECK(error.kind == ErrorKind::slicing);
      CHECK(error.stage == Stage::tetrahedralize);
      CHECK(!error.hint.empty());
      return error.code;
    }
    return std::string("none");
  };
  CHECK(code_of(join(cube(10), moved(cube(10), Vec3(5, 4, 3)))) == "tetrahedralize.failed");
  CHECK(code_of(join(sphere(10, 8), moved(sphere(10, 8), Vec3(7, 1, 2)))) ==
        "tetrahedralize.failed");
  CHECK(code_of(join(torus(20, 6, 40, 12), moved(torus(20, 6, 40, 12), Vec3(20, 3, 1)))) ==
        "tetrahedralize.failed");
  // Still usable afterwards.
  CHECK(total_volume(fill(cube(10), 2000)) == doctest::Approx(1000));
}

TEST_CASE("a surface without volume is refused") {
  Context ctx;
  CHECK_THROWS_AS(tetrahedralize(inverted(cube(10)), {}, ctx), Error);
  CHECK_THROWS_AS(tetrahedralize(TriMesh{Points(0, 3), Triangles(0, 3)}, {}, ctx), Error);
}

TEST_CASE("a surface with more triangles than the target allows is simplified, with a warning") {
  Context ctx;
  const TriMesh surface = sphere(10, 24);
  const Tetrahedralization made = tetrahedralize(surface, {.target_tets = 6000}, ctx);
  check_count(made.mesh, 6000);
  CHECK(made.approximated);
  CHECK(total_volume(made.mesh) == doctest::Approx(enclosed_volume(surface)).epsilon(0.01));
  REQUIRE(!ctx.warnings.empty());
  CHECK(ctx.warnings.back().code == "tetrahedralize.simplified");
  CHECK(ctx.warnings.back().message.find(std::to_string(surface.triangles.rows())) !=
        std::string::npos);
}

TEST_CASE("a surface that bends too much for the target is meshed with a warning with the count") {
  Context ctx;
  const TriMesh surface = sphere(10, 24);
  const TetMesh mesh = tetrahedralize(surface, {.target_tets = 300}, ctx).mesh;
  CHECK(mesh.tet_count() > 345);
  CHECK(total_volume(mesh) == doctest::Approx(enclosed_volume(surface)).epsilon(0.01));
  REQUIRE(ctx.warnings.size() == 2);
  CHECK(ctx.warnings[0].code == "tetrahedralize.more_tets");
  CHECK(ctx.warnings[0].message.find(std::to_string(mesh.tet_count())) != std::string::npos);
}

TEST_CASE("a cancel stops the mesher") {
  Context ctx;
  ctx.cancel_requested = true;
  CHECK_THROWS_AS(tetrahedralize(cube(10), {}, ctx), Cancelled);
}

TEST_CASE("the dihedral angles of a regular tet and of a cube's corner") {
  Points vertices(4, 3);
  vertices << 1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1;
  Tets tets(1, 4);
  tets << 0, 1, 2, 3;
  const DihedralRange regular = dihedral_range(make_tet_mesh(vertices, tets), 0);
  CHECK(regular.min == doctest::Approx(std::acos(1.0 / 3.0)));
  CHECK(regular.max == doctest::Approx(std::acos(1.0 / 3.0)));

  vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  const TetMesh corner = make_tet_mesh(vertices, tets);
  const TetQuality quality = tet_quality(corner);
  CHECK(quality.min_dihedral == doctest::Approx(std::acos(1.0 / std::sqrt(3.0))));
  CHECK(quality.max_dihedral == doctest::Approx(kPi / 2));
  CHECK(quality.min_volume == doctest::Approx(1.0 / 6.0));
  CHECK(quality.tets_below_10_deg == 0);
  REQUIRE(quality.worst_places.size() == 1);
  CHECK((quality.worst_places[0] - Vec3(0.25, 0.25, 0.25)).norm() < 1e-15);
}

TEST_CASE("a surface with a defect is never given to TetGen") {
  const TriMesh crossing = join(cube(10), moved(cube(10), Vec3(5, 4, 3)));
  Context ctx;
  try {
    tetrahedralize(crossing, {.target_tets = 2000, .backend = "tetgen"}, ctx, "it crosses itself");
    FAIL("not refused");
  } catch (const Error& error) {
    CHECK(error.code == "tetrahedralize.failed");
    CHECK(std::string(error.what()).find("it crosses itself") != std::string::npos);
  }
}

TEST_CASE("TetGen can be cancelled at any moment, and the next run is as if nothing had been") {
  // A surface that is kept, and one that is split.
  for (const TriMesh& surface : {sphere(10, 12), cube(20)}) {
    const TetrahedralizeParams params{.target_tets = 6000, .backend = "tetgen"};
    CancelAt never(0);
    const TetMesh whole = tetrahedralize(surface, params, never.ctx).mesh;
    CHECK(never.count > 200);
    constexpr int kMoments = 24;
    for (long i = 1; i < kMoments; ++i) {
      CancelAt moment(i * never.count / kMoments);
      CHECK_THROWS_AS(tetrahedralize(surface, params, moment.ctx), Cancelled);
    }
    CancelAt last(0);
    const TetMesh again = tetrahedralize(surface, params, last.ctx).mesh;
    CHECK(again.vertices == whole.vertices);
    CHECK(again.tets == whole.tets);
    CHECK(last.count == never.count);
  }
}
