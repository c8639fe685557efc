#include "mesh/wall_thickness.h"

#include <doctest/doctest.h>

#include <cmath>

#include "grid_mesh.h"
#include "tetrahedralize/tetrahedralize.h"

using namespace s3;

namespace {

TriMesh box(const Vec3& size) {
  return boundary_surface(test::make_grid(1, 1, 1, size));
}

WallThickness walls_of(const TriMesh& mesh) {
  Context ctx;
  return measure_walls(mesh, ctx);
}

}  // namespace

TEST_CASE("the thinnest wall of a plate is its thickness") {
  const WallThickness walls = walls_of(box(Vec3(100, 100, 1)));
  REQUIRE(walls.thinnest());
  CHECK(walls.thinnest()->thickness() == doctest::Approx(1));
  CHECK(std::abs(walls.thinnest()->from.z() - walls.thinnest()->to.z()) == doctest::Approx(1));
  CHECK(walls.walls.size() == walls.samples);
}

TEST_CASE("walls of less than 0.5 % of the surface do not matter") {
  // Two plates, 1 mm and 0.1 mm thick; the thin one's sides are a² each, of 20000 + 400 mm².
  for (const double side : {3.0, 10.0}) {
    TriMesh mesh = box(Vec3(100, 100, 1));
    const TriMesh thin = box(Vec3(side, side, 0.1));
    const auto first = static_cast<Index>(mesh.vertices.rows());
    mesh.vertices.conservativeResize(first + 8, 3);
    mesh.vertices.bottomRows(8) = thin.vertices.rowwise() + Eigen::RowVector3d(200, 0, 0);
    const Eigen::Index row = mesh.triangles.rows();
    mesh.triangles.conservativeResize(2 * row, 3);
    mesh.triangles.bottomRows(row) = thin.triangles.array() + first;
    const WallThickness walls = walls_of(mesh);
    REQUIRE(walls.thinnest());
    CHECK(walls.thinnest()->thickness() == doctest::Approx(side < 5 ? 1 : 0.1));
  }
}

TEST_CASE("a wedge of more than 30° is no wall") {
  TriMesh wedge{Points(6, 3), Triangles(8, 3)};
  wedge.vertices << 0, 0, 0, 10, 0, 0, 0, 0, 8, 0, 10, 0, 10, 10, 0, 0, 10, 8;
  wedge.triangles << 0, 1, 2, 3, 5, 4, 0, 3, 4, 0, 4, 1, 0, 2, 5, 0, 5, 3, 1, 4, 5, 1, 5, 2;
  const WallThickness walls = walls_of(wedge);
  for (const Wall& wall : walls.walls) CHECK(wall.thickness() == doctest::Approx(10));
}

TEST_CASE("the automatic target follows the thinnest wall") {
  const TriMesh plate = box(Vec3(60, 60, 1.5)), block = box(Vec3(50, 50, 50));
  // 5400 mm³ of regular tets with an edge of 0.63 mm: edge³/(6√2) each.
  CHECK(automatic_target(plate, walls_of(plate)) ==
        doctest::Approx(5400 * 6 * std::sqrt(2.0) / std::pow(0.63, 3)).epsilon(1e-3));
  CHECK(automatic_target(block, walls_of(block)) == 30000);
  const TriMesh sheet = box(Vec3(500, 500, 0.5));
  CHECK(automatic_target(sheet, walls_of(sheet)) == 1000000);
}

TEST_CASE("a plate of a single layer of tets is unresolved, one of two layers is not") {
  const Vec3 size(20, 20, 1);
  const WallThickness walls = walls_of(box(size));
  Context ctx;
  const TetMesh single = test::make_grid(20, 20, 1, size), two = test::make_grid(20, 20, 2, size);
  // The short sides, 20 mm through, are resolved either way: 80 of 880 mm².
  CHECK(static_cast<double>(unresolved_walls(single, walls, ctx).walls.size()) ==
        doctest::Approx(static_cast<double>(walls.samples) * 800 / 880).epsilon(2e-3));
  CHECK(unresolved_walls(two, walls, ctx).walls.empty());
  warn_about_thin_walls(two, walls, 4800, ctx);
  CHECK(ctx.warnings.empty());
}

TEST_CASE("the target that a warning about a thin wall names resolves the wall") {
  for (const Vec3& size : {Vec3(12, 9, 1), Vec3(16, 16, 2), Vec3(30, 3, 1.5)}) {
    const TriMesh surface = box(size);
    const WallThickness walls = walls_of(surface);
    const auto fill = [&](int target, Context& ctx) {
      return tetrahedralize(surface, {.target_tets = target}, ctx).mesh;
    };
    Context coarse, fine;
    warn_about_thin_walls(fill(500, coarse), walls, 500, coarse);
    const auto warning =
        std::find_if(coarse.warnings.begin(), coarse.warnings.end(),
                     [](const Warning& w) { return w.code == "tetrahedralize.thin_wall"; });
    REQUIRE(warning != coarse.warnings.end());
    const std::string marker = "mesh.target_tets of about ";
    const std::size_t at = warning->message.find(marker);
    REQUIRE(at != std::string::npos);
    const int needed = std::stoi(warning->message.substr(at + marker.size()));
    CHECK(unresolved_walls(fill(needed, fine), walls, fine).walls.size() <
          WallThickness::kLeastArea * static_cast<double>(walls.samples));
  }
}
