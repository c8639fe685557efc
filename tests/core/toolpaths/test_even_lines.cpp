#include "toolpaths/even_lines.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

using namespace s3;

namespace {

using Curve = std::function<Vec3(double)>;

/// A path through points at t = from, from + step, … on a surface with the given normals; its
/// thickness is z.
Path curve(const Curve& at, const Curve& normal, double from, double to, double step,
           PathKind kind = PathKind::infill) {
  Path path;
  path.kind = kind;
  const auto n = static_cast<Eigen::Index>(std::floor((to - from) / step)) + 1;
  path.points.resize(n, 3);
  path.normals.resize(n, 3);
  path.thickness.resize(n);
  path.width.setConstant(n, 1.0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = from + step * static_cast<double>(i);
    path.points.row(i) = at(t);
    path.normals.row(i) = normal(t);
    path.thickness(i) = path.points(i, 2);
  }
  return path;
}

Vec3 upward(double) {
  return Vec3::UnitZ();
}

Path row(double y, PathKind kind = PathKind::infill) {
  return curve([y](double t) { return Vec3(t, y, 0); }, upward, 0, 20, 0.37, kind);
}

std::vector<PlannedPath> walls_at(std::initializer_list<double> places) {
  std::vector<PlannedPath> walls;
  for (const double y : places) walls.push_back({row(y, PathKind::wall), 0, 0});
  return walls;
}

}  // namespace

TEST_CASE("what is left over between lines and walls is shared among them") {
  for (const double excess : {-0.3, 0.3, 0.5}) {
    CAPTURE(excess);
    // Drawn from right to left every second time: what is across points the other way.
    std::vector<std::vector<Path>> lines = {{row(1), row(2)}, {row(3)}};
    Path& turned = lines[0][1];
    turned.points = turned.points.colwise().reverse().eval();
    even_out(walls_at({0, 4 + excess}), 1.0, lines);
    double before = 0;
    for (const Path* path : {&lines[0][0], &lines[0][1], &lines[1][0]}) {
      const double y = path->points(20, 1);
      CHECK(y - before == doctest::Approx(1 + excess / 4).epsilon(0.08));
      CHECK((path->points.col(1).array() - y).abs().maxCoeff() < 1e-9);
      CHECK((path->width.array() - 1 - excess / 4).abs().maxCoeff() < 0.06);
      before = y;
    }
    CHECK(4 + excess - before == doctest::Approx(1 + excess / 4).epsilon(0.08));
    CHECK(lines[0][0].points(20, 0) == doctest::Approx(20 * 0.37));
  }
}

TEST_CASE("even lines, lines alone, and gaps of nearly two beads stay as they are") {
  const std::vector<std::vector<Path>> before = {{row(1), row(2)}, {}, {row(12)}};
  std::vector<std::vector<Path>> lines = before;
  even_out(walls_at({0, 3.75}), 1.0, lines);
  for (std::size_t area = 0; area < before.size(); ++area)
    for (std::size_t i = 0; i < before[area].size(); ++i) {
      CHECK((lines[area][i].points - before[area][i].points).cwiseAbs().maxCoeff() < 1e-12);
      CHECK((lines[area][i].width - before[area][i].width).cwiseAbs().maxCoeff() < 1e-12);
    }
  std::vector<std::vector<Path>> none;
  even_out({}, 1.0, none);
  CHECK(none.empty());
}

TEST_CASE("moved lines stay on a curved layer, with its normals and thickness") {
  constexpr double kRadius = 8;
  const auto on_cylinder = [&](double angle, PathKind kind = PathKind::infill) {
    const Vec3 normal(0, std::sin(angle), std::cos(angle));
    return curve([=](double t) -> Vec3 { return Vec3(t, 0, 0) + kRadius * normal; },
                 [=](double) { return Vec3(normal); }, 0, 20, 0.5, kind);
  };
  std::vector<std::vector<Path>> lines = {{on_cylinder(0.0), on_cylinder(1 / kRadius)}};
  const std::vector<PlannedPath> walls = {{on_cylinder(-1 / kRadius, PathKind::wall), 0, 0},
                                          {on_cylinder(2.5 / kRadius, PathKind::wall), 0, 0}};
  even_out(walls, 1.0, lines);
  CHECK(lines[0][1].points(20, 1) > kRadius * std::sin(1.2 / kRadius));  // it did move
  for (const Path& path : lines[0])
    for (Eigen::Index i = 0; i < path.points.rows(); ++i) {
      const Vec3 p = path.points.row(i), n = path.normals.row(i), out(0, p.y(), p.z());
      CHECK(out.norm() == doctest::Approx(kRadius).epsilon(2e-4));
      CHECK(n.dot(out.normalized()) > 1 - 1e-4);
      // Linear over one gap and a half.
      CHECK(path.thickness(i) == doctest::Approx(p.z()).epsilon(3.5e-3));
    }
}

TEST_CASE("a closed line moves alike at its start and everywhere else") {
  const auto circle = [](double radius, PathKind kind) {
    constexpr double kAround = 2 * 3.14159265358979323846;
    Path path = curve([=](double t) { return Vec3(radius * std::cos(t), radius * std::sin(t), 0); },
                      upward, 0, kAround - 1e-9, kAround / 180, kind);
    path.closed = true;
    return path;
  };
  std::vector<std::vector<Path>> lines = {{circle(10, PathKind::infill)}};
  const std::vector<PlannedPath> walls = {{circle(9, PathKind::wall), 0, 0},
                                          {circle(11.4, PathKind::wall), 0, 0}};
  even_out(walls, 1.0, lines);
  const Values radius = lines[0][0].points.rowwise().norm();
  CHECK(radius.maxCoeff() - radius.minCoeff() < 1e-6);
  CHECK(radius(0) == doctest::Approx(10.2).epsilon(0.005));
}

TEST_CASE("the gap before a line's end closes from both sides, and far lines stay") {
  std::vector<std::vector<Path>> lines(1);
  for (int k = -12; k <= 12; ++k)
    if (k != 0) lines[0].push_back(row(k > 0 ? k - 0.25 : k + 0.25));
  even_out({}, 1.0, lines);
  const double gap = lines[0][12].points(20, 1) - lines[0][11].points(20, 1);
  CHECK(gap < 1.2);
  CHECK(gap > 1.0);
  CHECK(std::abs(lines[0][0].points(20, 1) + 11.75) < 1e-3);
}
