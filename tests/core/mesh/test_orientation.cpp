#include "mesh/orientation.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "base/units.h"
#include "grid_mesh.h"
#include "mesh/placement.h"
#include "mesh/planar_hull.h"
#include "mesh/resting_pose.h"
#include "mesh/tri_mesh.h"

using namespace s3;

namespace {

constexpr double kAnyTurn = 2.1;
const Vec3 kAnyAxis = Vec3(1, -1, 0.3).normalized();

TriMesh turned(TriMesh mesh, const Eigen::AngleAxisd& rotation) {
  transform_points(Eigen::Affine3d(rotation), mesh.vertices);
  return mesh;
}

// The cells of a grid of 1 mm of which the middle fulfils the predicate.
TriMesh blocks(int nx, int ny, int nz, const std::function<bool(const Vec3&)>& solid) {
  const TetMesh grid = test::make_grid(nx, ny, nz, Vec3(nx, ny, nz));
  Tets kept(grid.tets.rows(), 4);
  Eigen::Index count = 0;
  for (Index t = 0; t < grid.tet_count(); ++t) {
    const Vec3 cell = grid.centroid(t).array().floor() + 0.5;
    if (solid(cell)) kept.row(count++) = grid.tets.row(t);
  }
  kept.conservativeResize(count, 4);
  return boundary_surface(make_tet_mesh(grid.vertices, kept));
}

// A T: a 12×4×2 beam on a 2×4×10 stem, standing.
TriMesh tee() {
  return blocks(12, 4, 12, [](const Vec3& c) { return c.z() > 10 || (c.x() > 5 && c.x() < 7); });
}

// A body of revolution about z through the points (radius, z), from the lower end to the upper one.
TriMesh turned_part(const std::vector<Vec2>& profile, int sides) {
  const auto rings = static_cast<Index>(profile.size());
  TriMesh mesh;
  mesh.vertices.resize(rings * sides + 2, 3);
  for (Index r = 0; r < rings; ++r)
    for (Index s = 0; s < sides; ++s) {
      const double angle = 2 * kPi * s / sides;
      const Vec2& p = profile[static_cast<std::size_t>(r)];
      mesh.vertices.row(r * sides + s) << p.x() * std::cos(angle), p.x() * std::sin(angle), p.y();
    }
  const Index below = rings * sides, above = below + 1;
  mesh.vertices.row(below) << 0, 0, profile.front().y();
  mesh.vertices.row(above) << 0, 0, profile.back().y();
  mesh.triangles.resize(2 * rings * sides, 3);
  Index f = 0;
  for (Index s = 0; s < sides; ++s) {
    const Index next = (s + 1) % sides;
    mesh.triangles.row(f++) << below, next, s;
    mesh.triangles.row(f++) << above, (rings - 1) * sides + s, (rings - 1) * sides + next;
    for (Index r = 0; r + 1 < rings; ++r) {
      mesh.triangles.row(f++) << r * sides + s, r * sides + next, (r + 1) * sides + next;
      mesh.triangles.row(f++) << r * sides + s, (r + 1) * sides + next, (r + 1) * sides + s;
    }
  }
  return mesh;
}

// Area of the regular polygon that turned_part() makes of a circle.
double polygon_area(double radius, int sides) {
  return 0.5 * sides * radius * radius * std::sin(2 * kPi / sides);
}

std::vector<Orientation> ranked(const TriMesh& mesh,
                                OrientationGoal goal = OrientationGoal::least_support) {
  return rank_orientations(mesh.vertices, mesh.triangles, goal);
}

}  // namespace

TEST_CASE("the hull of a square with points in it is its four corners") {
  const std::vector<Vec2> hull =
      convex_hull({{1, 1}, {0, 0}, {2, 0}, {1, 0}, {2, 2}, {0, 2}, {0, 0}});
  REQUIRE(hull.size() == 4);
  const HullBorder in = nearest_border(hull, Vec2(0.5, 1));
  CHECK(in.inside == doctest::Approx(0.5));
  CHECK((in.nearest - Vec2(0, 1)).norm() < 1e-15);
  CHECK(nearest_border(hull, Vec2(5, 6)).inside == doctest::Approx(-5));
}

TEST_CASE("the hull of points on a line has two corners and no inside") {
  const std::vector<Vec2> hull = convex_hull({{0, 0}, {1, 1}, {3, 3}, {2, 2}});
  REQUIRE(hull.size() == 2);
  CHECK(nearest_border(hull, Vec2(1, 1)).inside == doctest::Approx(0));
  CHECK(nearest_border(hull, Vec2(2, 0)).inside == doctest::Approx(-std::sqrt(2.0)));
}

TEST_CASE("a box rolls onto the side that it leans to") {
  const TriMesh mesh = blocks(4, 6, 3, [](const Vec3&) { return true; });
  const Vec3 center(2, 3, 1.5);
  // Up leans a little from z: the box falls back. On an edge, past the balance: it falls to y.
  CHECK(
      (resting_pose(mesh.vertices, center, Vec3(0.1, 0.2, 1).normalized()).value() - Vec3::UnitZ())
          .norm() < 1e-12);
  CHECK(
      (resting_pose(mesh.vertices, center, Vec3(0.05, 1, 0.3).normalized()).value() - Vec3::UnitY())
          .norm() < 1e-12);
}

TEST_CASE("a leaning column falls over") {
  // Its foot is 1 mm wide, its top 10 mm to the side.
  Points p(8, 3);
  p << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 10, 0, 10, 11, 0, 10, 10, 1, 10, 11, 1, 10;
  const std::optional<Vec3> up = resting_pose(p, Vec3(5.5, 0.5, 5), Vec3::UnitZ());
  REQUIRE(up);
  // It lies on the face that leans: outward normal (1, 0, −1).
  CHECK((*up - Vec3(-1, 0, 1).normalized()).norm() < 1e-9);
}

TEST_CASE("figures of a T that stands") {
  const TriMesh mesh = tee();
  const Orientation o = measure_orientation(mesh.vertices, mesh.triangles, Vec3::UnitZ());
  CHECK(o.overhang_area == doctest::Approx(10 * 4));
  CHECK(o.support_volume == doctest::Approx(10 * 4 * 10).epsilon(5e-3));
  CHECK(o.contact_area == doctest::Approx(2 * 4));
  CHECK(o.height == doctest::Approx(12));
  // The centre of mass: (80·5 + 96·11)/176 above the plate, 1 mm from the long edges of the foot.
  CHECK(o.tipping_deg == doctest::Approx(degrees(std::atan(1 / ((80 * 5 + 96 * 11) / 176.)))));
  CHECK(!o.stable);
  CHECK(o.rotate == "0,0,0");
}

TEST_CASE("figures of a T that stands on the end of its beam") {
  const TriMesh mesh = tee();
  // Only the stem overhangs: it sticks out 10 mm, 5 mm above the plate.
  const Orientation o = measure_orientation(mesh.vertices, mesh.triangles, Vec3::UnitX());
  CHECK(o.overhang_area == doctest::Approx(4 * 10));
  CHECK(o.support_volume == doctest::Approx(4 * 10 * 5).epsilon(5e-3));
  CHECK(o.contact_area == doctest::Approx(4 * 2));
}

TEST_CASE("support inside a C ends on its lower arm") {
  const TriMesh mesh =
      blocks(10, 3, 9, [](const Vec3& c) { return c.x() < 2 || c.z() < 2 || c.z() > 6; });
  const Orientation o = measure_orientation(mesh.vertices, mesh.triangles, Vec3::UnitZ());
  CHECK(o.overhang_area == doctest::Approx(8 * 3));
  CHECK(o.support_volume == doctest::Approx(8 * 3 * 4).epsilon(5e-3));
}

TEST_CASE("figures of a mushroom that stands, and its turning over") {
  constexpr int kSides = 48;
  const TriMesh mesh =
      turned_part({{3, 0}, {3, 12}, {10, 12}, {10, 14}, {8, 17}, {0.5, 20}}, kSides);
  const double ring = polygon_area(10, kSides) - polygon_area(3, kSides);
  const TriMesh tilted = turned(mesh, Eigen::AngleAxisd(kAnyTurn, kAnyAxis));
  const Vec3 up = Eigen::AngleAxisd(kAnyTurn, kAnyAxis) * Vec3::UnitZ();
  const Orientation o = measure_orientation(tilted.vertices, tilted.triangles, up);
  CHECK(o.overhang_area == doctest::Approx(ring));
  CHECK(o.support_volume == doctest::Approx(ring * 12).epsilon(5e-3));
  CHECK(o.contact_area == doctest::Approx(polygon_area(3, kSides)));
  CHECK(o.height == doctest::Approx(20));
}

TEST_CASE("a slope of exactly 45° does not overhang") {
  const TriMesh cone = turned_part({{1, 0}, {6, 5}, {6, 8}}, 4);
  // With four sides the slope is flatter than 45° in the middle of the sides: atan(√2).
  CHECK(measure_orientation(cone.vertices, cone.triangles, Vec3::UnitZ()).overhang_area == 0);
  const TriMesh roof = blocks(4, 4, 4, [](const Vec3&) { return true; });
  const Vec3 on_edge = Vec3(1, 0, 1).normalized();
  const Orientation o = measure_orientation(roof.vertices, roof.triangles, on_edge);
  CHECK(o.overhang_area == 0);
  CHECK(o.support_volume == 0);
  CHECK(!o.stable);
  // 1 % of the height above the edge it is 2 % as wide as high.
  CHECK(o.tipping_deg == doctest::Approx(degrees(std::atan(0.02))));
}

TEST_CASE("a T is turned over, wherever its file points") {
  for (const double turn : {0.0, 0.4, kAnyTurn}) {
    const Eigen::AngleAxisd rotation(turn, kAnyAxis);
    const TriMesh mesh = turned(tee(), rotation);
    const std::vector<Orientation> best = ranked(mesh);
    REQUIRE(best.size() == 5);
    // Nothing overhangs on the beam's 48 mm², nor when the T lies flat, on 44 mm².
    CHECK(best[0].overhang_area == doctest::Approx(0));
    CHECK(best[0].support_volume == doctest::Approx(0));
    CHECK(best[0].stable);
    CHECK(best[0].contact_area == doctest::Approx(48));
    CHECK((best[0].up + rotation * Vec3::UnitZ()).norm() < 1e-6);
    for (std::size_t i = 0; i < best.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        CHECK(best[i].up.dot(best[k].up) < std::cos(radians(9.99)));
  }
}

TEST_CASE("a round part stands on its foot, not on a point") {
  // An egg on a small flat foot: on its tip it would overhang less.
  std::vector<Vec2> egg;
  for (int i = 0; i <= 40; ++i) {
    const double z = -0.9 + 1.899 * i / 40;
    egg.emplace_back(20 * std::sqrt(1 - z * z), 35 * z);
  }
  const TriMesh mesh = turned(turned_part(egg, 40), Eigen::AngleAxisd(kAnyTurn, kAnyAxis));
  const Orientation best = ranked(mesh).front();
  CHECK((best.up - Eigen::AngleAxisd(kAnyTurn, kAnyAxis) * Vec3::UnitZ()).norm() < 1e-6);
  CHECK(best.stable);
  CHECK(best.contact_area == doctest::Approx(polygon_area(20 * std::sqrt(1 - 0.81), 40)));
}

TEST_CASE("a long rod is laid down, a short one stands") {
  const TriMesh rod = turned_part({{5, 0}, {5, 200}}, 36),
                stub = turned_part({{5, 0}, {5, 12}}, 36);
  CHECK(std::abs(ranked(rod).front().up.z()) < 1e-3);
  CHECK(ranked(stub).front().rotate == "0,0,0");
}

TEST_CASE("a mushroom stands on its foot, though its cap would overhang less below") {
  const TriMesh mesh =
      turned_part({{6, 0}, {5, 3}, {5, 12}, {12, 13}, {11, 16}, {8, 18.5}, {0.2, 20}}, 40);
  const Orientation turned_over =
      measure_orientation(mesh.vertices, mesh.triangles, Vec3(0.3, 0.1, -1).normalized());
  const Orientation best = ranked(mesh).front();
  CHECK(best.rotate == "0,0,0");
  CHECK(best.overhang_area > turned_over.overhang_area);
  CHECK(best.contact_area > turned_over.contact_area);
}

TEST_CASE("a tripod stands on its three feet, which have no common face") {
  // Three legs from a hub at (0, 0, 10) to points on a circle of radius 20.
  TriMesh mesh;
  mesh.vertices.resize(12, 3);
  mesh.triangles.resize(12, 3);
  for (Index leg = 0; leg < 3; ++leg) {
    const double angle = 2 * kPi * leg / 3;
    const Vec3 out(std::cos(angle), std::sin(angle), 0), side(-out.y(), out.x(), 0);
    const Index v = 4 * leg;
    mesh.vertices.row(v) = 20 * out;
    mesh.vertices.row(v + 1) = 2 * out + 2 * side + Vec3(0, 0, 10);
    mesh.vertices.row(v + 2) = 2 * out - 2 * side + Vec3(0, 0, 10);
    mesh.vertices.row(v + 3) = -1 * out + Vec3(0, 0, 13);
    const Index f = 4 * leg;
    mesh.triangles.row(f) << v, v + 1, v + 3;
    mesh.triangles.row(f + 1) << v, v + 3, v + 2;
    mesh.triangles.row(f + 2) << v, v + 2, v + 1;
    mesh.triangles.row(f + 3) << v + 1, v + 2, v + 3;
  }
  // Each leg is a tet with its centroid 8.25 above the plate; the feet's triangle has an inscribed
  // circle of radius 10.
  const Vec3 center(0, 0, 8.25), leaning(0.1, -0.2, 1);
  const std::optional<Vec3> up = resting_pose(mesh.vertices, center, leaning.normalized());
  REQUIRE(up);
  CHECK((*up - Vec3::UnitZ()).norm() < 1e-12);
  const Orientation o = measure_orientation(mesh.vertices, mesh.triangles, Vec3::UnitZ());
  CHECK(o.tipping_deg == doctest::Approx(degrees(std::atan(10 / 8.25))));
  CHECK(o.stable);
  CHECK(o.contact_area == 0);
}

TEST_CASE("flat lays the largest face down that reaches the plate") {
  // A cup, 10×10×6 with walls of 1 mm: the outside of its floor is larger than each wall's outside.
  const TriMesh cup = blocks(10, 10, 6, [](const Vec3& c) {
    return c.z() < 1 || c.x() < 1 || c.x() > 9 || c.y() < 1 || c.y() > 9;
  });
  const TriMesh mesh = turned(cup, Eigen::AngleAxisd(kAnyTurn, kAnyAxis));
  const std::vector<Orientation> best = ranked(mesh, OrientationGoal::flat_face);
  REQUIRE(best.size() == 5);
  CHECK((best[0].up - Eigen::AngleAxisd(kAnyTurn, kAnyAxis) * Vec3::UnitZ()).norm() < 1e-6);
  CHECK(best[0].contact_area == doctest::Approx(100));
  CHECK(best[1].contact_area == doctest::Approx(60));
}

TEST_CASE("a written rotation turns its direction up") {
  for (const Vec3& direction : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(0, -1, 0),
                                Vec3(0.3, -0.5, -0.9), Vec3(-1, 1e-9, 0)}) {
    const Vec3 up = direction.normalized();
    const Eigen::Affine3d t =
        placement(Points::Zero(1, 3), Triangles(0, 3), {.rotate = rotation_text(up)});
    CHECK((t.linear() * up - Vec3::UnitZ()).norm() < 1e-6);
  }
  CHECK(rotation_text(Vec3::UnitZ()) == "0,0,0");
  CHECK(rotation_text(-Vec3::UnitZ()) == "180,0,0");
  CHECK(rotation_text(Vec3::UnitY()) == "90,0,0");
  CHECK(rotation_text(Vec3::UnitX()) == "0,-90,0");
}

TEST_CASE("what has no extent is left as it is") {
  const std::vector<Orientation> best =
      rank_orientations(Points::Zero(3, 3), Triangles::Zero(2, 3), OrientationGoal::least_support);
  REQUIRE(best.size() == 1);
  CHECK(best[0].rotate == "0,0,0");
  CHECK(rank_orientations(Points::Zero(3, 3), Triangles::Zero(2, 3), OrientationGoal::flat_face)
            .empty());
}
