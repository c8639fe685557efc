#include "metrics/strain.h"

#include <cmath>
#include <span>
#include <string>

#include <doctest/doctest.h>

#include "base/error.h"
#include "base/units.h"
#include "grid_mesh.h"
#include "mesh/reorder.h"

using namespace s3;

namespace {

/// Straight beads through a box on horizontal layers, all along x or all along y.
Waypoints straight_beads(const Vec3& size, bool along_x) {
  std::vector<Vec3> points;
  for (double z = 0.25; z < size.z(); z += 0.5)
    for (double w = 0.25; w < (along_x ? size.y() : size.x()); w += 0.5)
      for (const double end : {0.0, 1.0})
        points.emplace_back(along_x ? Vec3(end * size.x(), w, z) : Vec3(w, end * size.y(), z));
  Waypoints beads;
  beads.position.resize(static_cast<Eigen::Index>(points.size()), 3);
  beads.normal = Vec3::UnitZ().transpose().replicate(beads.position.rows(), 1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    beads.position.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
    beads.travel.push_back(i % 2 == 0 ? 1 : 0);
  }
  return beads;
}

LoadCases pull_along_x(double length) {
  const std::string text =
      R"({"conditions": [
        {"region": {"plane": {"point": [0, 0, 0], "normal": [-1, 0, 0]}}, "fixed": "x"},
        {"region": {"plane": {"point": [0, 0, 0], "normal": [0, -1, 0]}}, "fixed": "y"},
        {"region": "plate", "fixed": "z"},
        {"region": {"plane": {"point": [)" +
      std::to_string(length) + R"(, 0, 0], "normal": [1, 0, 0]}}, "pressure": -2}]})";
  return read_load_cases(std::as_bytes(std::span(text.data(), text.size())), "pull.json");
}

}  // namespace

TEST_CASE("a bar's strain is that of its beads: along them and across") {
  const Vec3 size(8, 3, 2);
  const TetMesh mesh = reorder_along_morton(test::make_grid(8, 3, 2, size));
  Context ctx;
  const auto figures_of = [&](bool along_x) {
    return strain_figures(printed_strain(mesh, straight_beads(size, along_x), pull_along_x(8), ctx),
                          tet_volumes(mesh));
  };
  const auto along = figures_of(true), across = figures_of(false);
  for (const auto& [figures, young] : {std::pair{along, 3500.0}, std::pair{across, 1200.0}}) {
    CHECK(figures.mean == doctest::Approx(2 / young).epsilon(1e-3));
    CHECK(figures.max == doctest::Approx(2 / young).epsilon(1e-3));
    CHECK(figures.p999 == doctest::Approx(2 / young).epsilon(1e-3));
  }
}

TEST_CASE("mean and percentile of the strain are weighted by volume") {
  Values strain(4), volume(4);
  strain << 5, 1, 2, 9;
  volume << 0.5, 996, 3, 0.5;
  const StrainFigures figures = strain_figures(strain, volume);
  CHECK(figures.max == 9);
  CHECK(figures.p999 == 2);  // 999 of 1000 mm³ are at most 2
  CHECK(figures.mean == doctest::Approx((2.5 + 996 + 6 + 4.5) / 1000));
}

TEST_CASE("every tet takes the frame of the nearest bead") {
  const TetMesh mesh = reorder_along_morton(test::make_grid(6, 6, 6, {6, 6, 6}));
  // Circles around the z axis of the box on cones, with a travel between them.
  Waypoints beads;
  std::vector<Vec3> points, normals;
  for (double radius = 0.5; radius < 5; radius += 0.5)
    for (double z = 0.25; z < 9; z += 0.5)
      for (int k = 0; k <= 60; ++k) {
        const double a = 2 * kPi * k / 60;
        points.emplace_back(3 + radius * std::cos(a), 3 + radius * std::sin(a), z - 0.3 * radius);
        normals.emplace_back(Vec3(0.3 * std::cos(a), 0.3 * std::sin(a), 1).normalized());
        beads.travel.push_back(k == 0 ? 1 : 0);
      }
  const auto count = static_cast<Eigen::Index>(points.size());
  beads.position.resize(count, 3);
  beads.normal.resize(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    beads.position.row(i) = points[static_cast<std::size_t>(i)].transpose();
    beads.normal.row(i) = normals[static_cast<std::size_t>(i)].transpose();
  }
  Context one(1), three(3);
  const auto frames = bead_frames(mesh, beads, one);
  CHECK(frames == bead_frames(mesh, beads, three));
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    const Mat3& frame = frames[static_cast<std::size_t>(t)];
    CHECK((frame.transpose() * frame - Mat3::Identity()).norm() < 1e-12);
    CHECK(frame.determinant() == doctest::Approx(1));
    const Vec3 from_axis = mesh.centroid(t) - Vec3(3, 3, mesh.centroid(t).z());
    if (from_axis.norm() < 1) continue;  // there the circles turn within a bead's width
    const Vec3 out = from_axis.normalized(), tangent = Vec3::UnitZ().cross(out);
    CHECK(std::abs(frame.col(0).dot(tangent)) > std::cos(radians(6)));
    CHECK(frame.col(2).dot((0.3 * out + Vec3::UnitZ()).normalized()) > std::cos(radians(6)));
  }
}

TEST_CASE("without beads there is nothing to measure") {
  const TetMesh mesh = test::make_grid(2, 2, 2, {2, 2, 2});
  Waypoints beads = straight_beads({2, 2, 2}, true);
  beads.travel.assign(beads.travel.size(), 1);
  Context ctx;
  CHECK_THROWS_AS(bead_frames(mesh, beads, ctx), Error);
}
