#include "mesh/aabb_tree.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

using namespace s3;

namespace {

// A wavy closed-ish sheet of 2·n² triangles, with a few flat triangles among them.
TriMesh wavy_sheet(int n) {
  TriMesh mesh;
  mesh.vertices.resize((n + 1) * (n + 1), 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.vertices.row(j * (n + 1) + i) << i, j, 2 * std::sin(0.7 * i) * std::cos(0.4 * j);
  mesh.triangles.resize(2 * n * n, 3);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int v = j * (n + 1) + i;
      mesh.triangles.row(2 * (j * n + i)) << v, v + 1, v + n + 2;
      mesh.triangles.row(2 * (j * n + i) + 1) << v, v + n + 2, v + n + 1;
    }
  return mesh;
}

TriMesh random_soup(int n, std::mt19937& random) {
  std::uniform_real_distribution<double> at(-10, 10), size(-1, 1);
  TriMesh mesh;
  mesh.vertices.resize(3 * n, 3);
  mesh.triangles.resize(n, 3);
  for (int f = 0; f < n; ++f) {
    const Vec3 center(at(random), at(random), at(random));
    for (int i = 0; i < 3; ++i)
      mesh.vertices.row(3 * f + i) = center + Vec3(size(random), size(random), size(random));
    mesh.triangles.row(f) << 3 * f, 3 * f + 1, 3 * f + 2;
  }
  return mesh;
}

// Dense sampling of the triangle followed by a local refinement: independent of the closed form.
double sampled_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  double u = 1.0 / 3, v = 1.0 / 3, step = 0.34, best = (p - a - u * (b - a) - v * (c - a)).norm();
  while (step > 1e-9) {
    bool better = false;
    for (int k = 0; k < 16; ++k) {
      const double angle = k * std::numbers::pi / 8;
      const double nu = std::clamp(u + step * std::cos(angle), 0.0, 1.0);
      const double nv = std::clamp(v + step * std::sin(angle), 0.0, 1 - nu);
      const double d = (p - a - nu * (b - a) - nv * (c - a)).norm();
      if (d < best) best = d, u = nu, v = nv, better = true;
    }
    if (!better) step *= 0.6;
  }
  return best;
}

Closest brute_force(const TriMesh& mesh, const Vec3& p) {
  Closest best;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    Closest one = closest_on_triangle(p, mesh.vertices.row(mesh.triangles(f, 0)),
                                      mesh.vertices.row(mesh.triangles(f, 1)),
                                      mesh.vertices.row(mesh.triangles(f, 2)));
    one.triangle = static_cast<Index>(f);
    if (one.distance < best.distance) best = one;
  }
  return best;
}

}  // namespace

TEST_CASE("the closest point of a triangle is as near as a search finds") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-2, 2);
  const auto point = [&] { return Vec3(at(random), at(random), at(random)); };
  for (int i = 0; i < 300; ++i) {
    const Vec3 a = point(), b = point(), c = point(), p = point();
    const Closest closest = closest_on_triangle(p, a, b, c);
    CHECK(closest.distance == doctest::Approx(sampled_distance(p, a, b, c)).epsilon(1e-4));
    const Vec3 w = closest.barycentric;
    CHECK(w.minCoeff() >= -1e-12);
    CHECK(w.sum() == doctest::Approx(1));
    CHECK((closest.point - (w[0] * a + w[1] * b + w[2] * c)).norm() < 1e-12);
    CHECK((closest.point - p).norm() == doctest::Approx(closest.distance));
  }
}

TEST_CASE("triangles without area answer with their edges") {
  const Vec3 a(0, 0, 0), b(1, 1, 1), c(3, 3, 3), p(2, 2, 3);
  CHECK(closest_on_triangle(p, a, b, c).distance == doctest::Approx(std::sqrt(2.0 / 3)));
  CHECK(closest_on_triangle(p, a, c, b).distance == doctest::Approx(std::sqrt(2.0 / 3)));
  CHECK(closest_on_triangle(p, a, a, a).distance == doctest::Approx(p.norm()));
  CHECK(closest_on_triangle(p, b, b, c).distance == doctest::Approx(std::sqrt(2.0 / 3)));
}

TEST_CASE("the tree finds the closest point that a walk over all triangles finds") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at(-15, 25);
  for (const TriMesh& mesh :
       {wavy_sheet(12), random_soup(500, random), random_soup(1, random), random_soup(5, random)}) {
    const AabbTree tree(mesh);
    for (int i = 0; i < 500; ++i) {
      const Vec3 p(at(random), at(random), at(random));
      const Closest expected = brute_force(mesh, p), got = tree.closest(p);
      REQUIRE(got.triangle >= 0);
      CHECK(got.distance == doctest::Approx(expected.distance).epsilon(1e-12));
      CHECK((got.point - p).norm() == doctest::Approx(got.distance));
      const auto corner = [&](int k) -> Vec3 {
        return mesh.vertices.row(mesh.triangles(got.triangle, k));
      };
      const Vec3 w = got.barycentric;
      CHECK((w[0] * corner(0) + w[1] * corner(1) + w[2] * corner(2) - got.point).norm() < 1e-12);

      const double near_bound = got.distance * (1 + 1e-9);
      CHECK(tree.closest(p, near_bound).distance == got.distance);
      CHECK(tree.closest(p, got.distance * (1 - 1e-9)).triangle == -1);
    }
  }
}

TEST_CASE("equal triangles and an empty mesh do no harm") {
  CHECK(AabbTree(TriMesh{}).closest(Vec3::Zero()).triangle == -1);
  CHECK(AabbTree(TriMesh{}).first_hit(Vec3::Zero(), Vec3::UnitX()).triangle == -1);
  TriMesh mesh;
  mesh.vertices.resize(3, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  mesh.triangles = Triangles::Zero(1000, 3);
  mesh.triangles.col(1).setConstant(1);
  mesh.triangles.col(2).setConstant(2);
  const AabbTree tree(mesh);
  CHECK(tree.closest(Vec3(0.2, 0.2, 3)).distance == doctest::Approx(3));
  CHECK(tree.all_hits(Vec3(0.2, 0.2, 3), -Vec3::UnitZ()).size() == 1000);
}

TEST_CASE("triangles that lie closer than numbers can divide do no harm") {
  constexpr Index kTriangles = 64;
  constexpr double kStep = std::numeric_limits<double>::denorm_min();
  TriMesh mesh{Points::Zero(3 * kTriangles, 3), Triangles(kTriangles, 3)};
  for (Index t = 0; t < kTriangles; ++t) {
    mesh.triangles.row(t) << 3 * t, 3 * t + 1, 3 * t + 2;
    mesh.vertices.row(3 * t + 1) << 6 * t * kStep, 0, 0;
  }
  const AabbTree tree(mesh);
  CHECK(tree.closest(Vec3(0, 0, 1)).distance == doctest::Approx(1));
}

TEST_CASE("a ray meets the triangles that a walk over all triangles meets") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> at(-10, 10);
  const TriMesh mesh = random_soup(400, random);
  const AabbTree tree(mesh);
  int hit_rays = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 origin(at(random), at(random), at(random));
    Vec3 direction(at(random), at(random), at(random));
    if (i % 3 == 0) direction = Vec3::UnitZ() * (i % 2 ? 1 : -1);
    // Solve origin + t·d = a + u·ab + v·ac with a general solver, not the tree's own formula.
    std::set<Index> expected;
    for (Index f = 0; f < mesh.triangles.rows(); ++f) {
      const Vec3 a = mesh.vertices.row(3 * f), b = mesh.vertices.row(3 * f + 1),
                 c = mesh.vertices.row(3 * f + 2);
      Mat3 system;
      system << b - a, c - a, -direction;
      const Vec3 uvt = system.inverse() * (origin - a);
      if (uvt[0] >= 0 && uvt[1] >= 0 && uvt[0] + uvt[1] <= 1 && uvt[2] >= 0) expected.insert(f);
    }
    const std::vector<RayHit> hits = tree.all_hits(origin, direction);
    std::set<Index> got;
    for (const RayHit& hit : hits) got.insert(hit.triangle);
    CHECK(got == expected);
    CHECK(std::is_sorted(hits.begin(), hits.end(),
                         [](const RayHit& x, const RayHit& y) { return x.t < y.t; }));
    const RayHit first = tree.first_hit(origin, direction);
    CHECK(first.triangle == (hits.empty() ? -1 : hits[0].triangle));
    hit_rays += !hits.empty();
  }
  CHECK(hit_rays > 25);
}

TEST_CASE("a box finds the triangles whose boxes meet it") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(-10, 10);
  const TriMesh mesh = random_soup(300, random);
  const AabbTree tree(mesh);
  std::vector<Index> found;
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(at(random), at(random), at(random)), q(at(random), at(random), at(random));
    const Box box{p.cwiseMin(q), p.cwiseMax(q)};
    std::vector<Index> expected;
    for (Index f = 0; f < mesh.triangles.rows(); ++f) {
      const auto corners = mesh.vertices.middleRows(3 * f, 3);
      if ((corners.colwise().minCoeff().transpose().array() <= box.max.array()).all() &&
          (corners.colwise().maxCoeff().transpose().array() >= box.min.array()).all())
        expected.push_back(f);
    }
    tree.triangles_in_box(box, found);
    std::sort(found.begin(), found.end());
    CHECK(found == expected);
  }
}
