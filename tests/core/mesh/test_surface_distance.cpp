#include "mesh/surface_distance.h"

#include <doctest/doctest.h>

#include "test_shapes.h"

using namespace s3;
using namespace s3::test;

TEST_CASE("concentric spheres are apart by the difference of their radii, both ways") {
  Context ctx;
  const SurfaceDistance d = surface_distance(sphere(10.5, 60), sphere(10, 60), nullptr, ctx);
  for (const DistanceFigures& f : {d.from_made, d.from_given}) {
    CHECK(f.mean == doctest::Approx(0.5).epsilon(0.01));
    CHECK(f.p95 == doctest::Approx(0.5).epsilon(0.01));
    CHECK(f.max == doctest::Approx(0.5).epsilon(0.01));
  }
  CHECK(d.inner_share == 0);
}

TEST_CASE("what only one surface has is seen from this one only, with its place") {
  Context ctx;
  const TriMesh ball = sphere(10, 20),
                with_satellite = join(ball, moved(sphere(1, 10), Vec3(40, 0, 0)));
  const SurfaceDistance d = surface_distance(ball, with_satellite, nullptr, ctx);
  CHECK(d.from_made.max < 1e-12);
  CHECK(d.from_given.max == doctest::Approx(31).epsilon(0.01));
  CHECK((d.from_given.place - Vec3(41, 0, 0)).norm() < 0.5);
  CHECK(d.from_given.p95 < 1e-12);  // the satellite has 1 % of the area
  CHECK(d.max() == d.from_given.max);
}

TEST_CASE("faces inside a body are left out of the distance to a solid") {
  Context ctx;
  const TriMesh given = join(sphere(10, 20), sphere(5, 20));  // winding number 2 in the middle
  const WindingNumber solid(given);
  const SurfaceDistance d = surface_distance(sphere(10, 20), given, &solid, ctx);
  CHECK(d.from_given.max < 1e-12);
  CHECK(d.inner_share == doctest::Approx(0.2).epsilon(0.01));
  CHECK(surface_distance(sphere(10, 20), given, nullptr, ctx).from_given.max > 4.5);
}

TEST_CASE("the distance does not depend on the number of threads") {
  Context one(1), three(3);
  const TriMesh a = torus(20, 6, 40, 12), b = torus(20, 6, 60, 20);
  const WindingNumber solid(b);
  const SurfaceDistance d1 = surface_distance(a, b, &solid, one),
                        d3 = surface_distance(a, b, &solid, three);
  CHECK(d1.from_made.mean == d3.from_made.mean);
  CHECK(d1.from_given.p95 == d3.from_given.p95);
  CHECK(d1.from_given.place == d3.from_given.place);
}
