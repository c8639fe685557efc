#include "mesh/winding_number.h"

#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "test_shapes.h"

using namespace s3;
using namespace s3::test;

namespace {

double worst_error(const TriMesh& mesh, double reach, int queries) {
  const WindingNumber winding(mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-reach, reach);
  double worst = 0;
  for (int i = 0; i < queries; ++i) {
    const Vec3 p(at(random), at(random), at(random));
    worst = std::max(worst, std::abs(winding.at(p) - winding.exact(p)));
  }
  return worst;
}

TriMesh random_soup(int n) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> at(-10, 10), size(-1, 1);
  TriMesh mesh{Points(3 * n, 3), Triangles(n, 3)};
  for (int f = 0; f < n; ++f) {
    const Vec3 center(at(random), at(random), at(random));
    for (int i = 0; i < 3; ++i)
      mesh.vertices.row(3 * f + i) = center + Vec3(size(random), size(random), size(random));
    mesh.triangles.row(f) << 3 * f, 3 * f + 1, 3 * f + 2;
  }
  return mesh;
}

}  // namespace

TEST_CASE(
    "the winding number is 1 inside, 0 outside and in cavities, 2 in overlaps, -1 inside out") {
  const TriMesh ball = sphere(10, 12);
  const WindingNumber one(ball);
  CHECK(one.at(Vec3(1, 2, 3)) == doctest::Approx(1).epsilon(1e-2));
  CHECK(one.at(Vec3(9.8, 0, 0)) == doctest::Approx(1).epsilon(1e-2));
  CHECK(std::abs(one.at(Vec3(10.1, 0, 0))) < 1e-2);
  CHECK(std::abs(one.at(Vec3(300, 200, -100))) < 1e-2);

  const WindingNumber overlap(join(ball, moved(ball, Vec3(8, 0, 0))));
  CHECK(overlap.at(Vec3(4, 0, 0)) == doctest::Approx(2).epsilon(1e-2));
  CHECK(overlap.at(Vec3(-4, 0, 0)) == doctest::Approx(1).epsilon(1e-2));

  const WindingNumber hollow(join(ball, inverted(sphere(5, 12))));
  CHECK(std::abs(hollow.at(Vec3(1, 1, 1))) < 1e-2);
  CHECK(hollow.at(Vec3(7, 0, 1)) == doctest::Approx(1).epsilon(1e-2));

  CHECK(WindingNumber(inverted(ball)).at(Vec3(1, 2, 3)) == doctest::Approx(-1).epsilon(1e-2));
}

TEST_CASE("an open cube's winding number in its middle is its share of the full solid angle") {
  TriMesh open = cube(2);
  open.triangles.conservativeResize(10, 3);  // without one face
  CHECK(WindingNumber(open).at(Vec3(1, 1, 1)) == doctest::Approx(5.0 / 6).epsilon(1e-12));
}

TEST_CASE("a disc seen from its axis has the winding number of a cone") {
  constexpr int n = 400;
  TriMesh disc{Points(n + 1, 3), Triangles(n, 3)};
  disc.vertices.row(n) << 0, 0, 0;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * kPi * i / n;
    disc.vertices.row(i) << std::cos(angle), std::sin(angle), 0;
    disc.triangles.row(i) << n, i, (i + 1) % n;
  }
  const WindingNumber winding(disc);
  for (const double z : {0.3, 1.0, 2.5, 10.0}) {
    const double share =
        0.5 * (1 - z / std::sqrt(1 + z * z));  // Ω = 2π (1 − cos of the half angle)
    CHECK(winding.at(Vec3(0, 0, -z)) == doctest::Approx(share).epsilon(1e-2));
    CHECK(winding.at(Vec3(0, 0, z)) == doctest::Approx(-share).epsilon(1e-2));
  }
}

TEST_CASE("the tree's winding number is near the plain sum, for closed surfaces and soups") {
  CHECK(worst_error(sphere(10, 20), 12, 2000) < 1e-2);
  CHECK(worst_error(torus(20, 6, 80, 30), 30, 2000) < 1e-2);
  CHECK(worst_error(random_soup(3000), 15, 1000) < 5e-2);  // adds up thousands of free ends
}

TEST_CASE("the winding number does not change with scale and place") {
  const TriMesh ball = sphere(1, 8);
  TriMesh far = ball;
  far.vertices *= 1024;
  far.vertices.rowwise() += Vec3(1e6, -1e6, 5e5).transpose();
  const WindingNumber near_one(ball), far_one(far);
  for (const Vec3& p : {Vec3(0.1, 0.2, 0.3), Vec3(0, 0, 0.9), Vec3(1.2, 0, 0.1)})
    CHECK(far_one.at(1024 * p + Vec3(1e6, -1e6, 5e5)) ==
          doctest::Approx(near_one.at(p)).epsilon(1e-4));
}

TEST_CASE("triangles without area and surfaces without triangles wind around nothing") {
  TriMesh flat = cube(2);
  flat.triangles.conservativeResize(14, 3);
  flat.triangles.row(12) << 0, 0, 1;
  flat.triangles.row(13) << 3, 3, 3;
  CHECK(WindingNumber(flat).at(Vec3(1, 1, 1)) == doctest::Approx(1));
  CHECK(WindingNumber(TriMesh{Points(0, 3), Triangles(0, 3)}).at(Vec3(1, 1, 1)) == 0);
  CHECK(WindingNumber().at(Vec3(1, 1, 1)) == 0);
}

TEST_CASE("far from few triangles the expansion's error falls with the fifth power") {
  TriMesh open = cube(2);
  open.triangles.conservativeResize(7, 3);  // one node of the tree; all moments are there
  const WindingNumber winding(open);
  const auto error = [&](double distance) {
    const Vec3 p = distance * Vec3(0.6, -0.48, 0.64);
    return std::abs(winding.at(p) - winding.exact(p));
  };
  const double near_error = error(20), far_error = error(40);
  CHECK(near_error > 0);
  CHECK(far_error < near_error / 25);
}
