#include "metrics/print_metrics.h"

#include <doctest/doctest.h>

#include "base/units.h"
#include "grid_mesh.h"

namespace {

using s3::Index;
using s3::Vec3;

s3::Waypoints waypoints_along(const std::vector<Vec3>& points, double width, double height) {
  s3::Waypoints w;
  const auto n = static_cast<Eigen::Index>(points.size());
  w.position.resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) w.position.row(i) = points[static_cast<std::size_t>(i)];
  w.normal = Vec3::UnitZ().transpose().replicate(n, 1);
  w.tangent = Vec3::UnitX().transpose().replicate(n, 1);
  w.width = s3::Values::Constant(n, width);
  w.height = s3::Values::Constant(n, height);
  w.extrusion = s3::Values::Zero(n);
  w.speed = s3::Values::Constant(n, 20);
  const auto size = points.size();
  w.component.assign(size, 0);
  w.layer.assign(size, 0);
  w.path.assign(size, 0);
  w.kind.assign(size, s3::PathKind::wall);
  w.travel.assign(size, 0);
  if (size > 0) w.travel[0] = 1;
  return w;
}

}  // namespace

TEST_CASE("the length of open and closed paths, coverage of the area, overlap of its wide part") {
  s3::Toolpaths toolpaths;
  s3::Path path;
  path.points.resize(4, 3);
  path.points << 0, 0, 0, 10, 0, 0, 10, 10, 0, 0, 10, 0;
  s3::Path ring = path;
  ring.closed = true;
  toolpaths.layers.push_back({0, {path}, 100, 90, 4, 50, 0});
  toolpaths.layers.push_back({1, {ring}, 300, 290, 0, 150, 0});
  s3::Metrics m;
  s3::toolpath_metrics(toolpaths, m);
  CHECK(*m.path_length_mm == doctest::Approx(70));
  CHECK(*m.coverage_percent == doctest::Approx(95));
  CHECK(*m.overlap_percent == doctest::Approx(2));
}

TEST_CASE("no toolpaths: a length of 0 is a fact, a coverage is not") {
  s3::Metrics m;
  s3::toolpath_metrics({}, m);
  CHECK(*m.path_length_mm == 0);
  CHECK_FALSE(m.coverage_percent.has_value());
  CHECK_FALSE(m.overlap_percent.has_value());
}

TEST_CASE("material is filament times its cross-section and density, time is way over speed") {
  auto w = waypoints_along({{0, 0, 0}, {10, 0, 0}, {10, 30, 0}}, 1, 0.5);
  w.extrusion << 0, 4, 6;
  w.speed << 100, 20, 10;
  s3::MachineProfile machine;
  machine.filament_diameter = 2;
  machine.filament_density = 1e-3;
  s3::Metrics m;
  s3::waypoint_metrics(w, machine, m);
  CHECK(*m.material_g == doctest::Approx(10 * s3::kPi * 1e-3));
  CHECK(*m.print_time_s == doctest::Approx(0.5 + 3));
}

TEST_CASE("surface error: the distance from a plane to a tube below it") {
  // One long bead along x with a round tube of radius r, its axis half a bead height below z = 10.
  // Samples come from a strip of the plane z = 12 above the bead, 0.02 wide.
  const double width = 1, height = 0.5;
  const auto w = waypoints_along({{-50, 0, 10}, {50, 0, 10}}, width, height);
  s3::TriMesh strip;
  strip.vertices.resize(4, 3);
  strip.vertices << -20, -0.01, 12, 20, -0.01, 12, 20, 0.01, 12, -20, 0.01, 12;
  strip.triangles.resize(2, 3);
  strip.triangles << 0, 1, 2, 0, 2, 3;
  s3::Context ctx;
  s3::Metrics m;
  s3::surface_error(strip, w, m, ctx);
  const double radius = std::sqrt(width * height / s3::kPi);
  CHECK(*m.surface_error_avg_mm == doctest::Approx(2 + height / 2 - radius).epsilon(1e-4));
  CHECK(*m.surface_error_max_mm == doctest::Approx(2 + height / 2 - radius).epsilon(1e-4));
}

TEST_CASE("surface error by the grid is the error by looking at every tube") {
  std::vector<Vec3> points;
  for (int i = 0; i < 400; ++i)
    points.emplace_back(8 * std::cos(0.3 * i), 6 * std::sin(0.31 * i),
                        0.05 * i * std::cos(0.01 * i));
  const auto w = waypoints_along(points, 0.6, 0.3);
  const auto box = s3::test::make_grid(1, 1, 1, {30, 4, 9});
  s3::TriMesh probe;  // one tiny triangle at a time: its samples are at one point
  s3::Context ctx;
  for (Index v = 0; v < box.vertex_count(); ++v) {
    const Vec3 p = box.vertices.row(v);
    probe.vertices.resize(3, 3);
    probe.vertices << p.x(), p.y(), p.z(), p.x() + 1e-9, p.y(), p.z(), p.x(), p.y() + 1e-9, p.z();
    probe.triangles.resize(1, 3);
    probe.triangles << 0, 1, 2;
    s3::Metrics m;
    s3::surface_error(probe, w, m, ctx);
    double best = HUGE_VAL;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const Vec3 a = points[i - 1] - Vec3(0, 0, 0.15), b = points[i] - Vec3(0, 0, 0.15);
      const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
      best = std::min(best, (a + t * (b - a) - p).norm() - std::sqrt(0.6 * 0.3 / s3::kPi));
    }
    CHECK(*m.surface_error_avg_mm == doctest::Approx(std::abs(best)).epsilon(1e-6));
  }
}

TEST_CASE("without a bead there is no surface error to report") {
  const auto box = s3::test::make_grid(1, 1, 1, {1, 1, 1});
  s3::Context ctx;
  s3::Metrics m;
  s3::surface_error(s3::boundary_surface(box), {}, m, ctx);
  CHECK_FALSE(m.surface_error_avg_mm.has_value());
}
