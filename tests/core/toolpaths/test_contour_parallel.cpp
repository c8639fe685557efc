#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "layer_shapes.h"
#include "toolpaths/make_toolpaths.h"

using namespace s3;
using namespace s3::test;

namespace {

double share(double part, double whole) {
  return whole > 0 ? 100 * part / whole : 0;
}

std::vector<const Path*> walls(const LayerPaths& paths) {
  std::vector<const Path*> result;
  for (const Path& p : paths.paths)
    if (p.kind == PathKind::wall) result.push_back(&p);
  return result;
}

double bead_area(const LayerPaths& paths) {
  double area = 0;
  for (const Path& p : paths.paths) {
    const Eigen::Index n = p.points.rows();
    for (Eigen::Index i = 0; i + 1 < n + (p.closed ? 1 : 0); ++i)
      area += (p.points.row((i + 1) % n) - p.points.row(i)).norm() * 0.5 *
              (p.width(i) + p.width((i + 1) % n));
  }
  return area;
}

/// An own measure: random-free grid samples over the shape, a bead is a capsule around each segment
/// of its width.
double covered_share(const Layer& layer, const LayerPaths& paths, double step) {
  double total = 0, covered = 0;
  for (Eigen::Index f = 0; f < layer.surface.triangles.rows(); ++f) {
    const Vec3 a = layer.surface.vertices.row(layer.surface.triangles(f, 0)),
               b = layer.surface.vertices.row(layer.surface.triangles(f, 1)),
               c = layer.surface.vertices.row(layer.surface.triangles(f, 2));
    const double area = 0.5 * (b - a).cross(c - a).norm();
    const int m = std::max(1, static_cast<int>(std::sqrt(area) / step));
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < m; ++j) {
        // A square of samples folded onto the triangle.
        double u = (i + 0.6) / m, v = (j + 0.3) / m;
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const Vec3 p = a + u * (b - a) + v * (c - a);
        bool hit = false;
        for (const Path& path : paths.paths) {
          const Eigen::Index n = path.points.rows();
          for (Eigen::Index k = 0; !hit && k + 1 < n + (path.closed ? 1 : 0); ++k) {
            const Vec3 q = path.points.row(k), r = Vec3(path.points.row((k + 1) % n)) - q;
            const double t =
                r.squaredNorm() > 0 ? std::clamp((p - q).dot(r) / r.squaredNorm(), 0.0, 1.0) : 0.0;
            hit = (p - q - t * r).norm() <=
                  0.5 * ((1 - t) * path.width(k) + t * path.width((k + 1) % n));
          }
        }
        total += area / (m * m);
        covered += hit ? area / (m * m) : 0;
      }
  }
  return 100 * covered / total;
}

}  // namespace

TEST_CASE("a disc gets concentric rings one bead apart") {
  Context ctx;
  const LayerPaths paths = contour_parallel(make_disc(10.2, 0.7), 1.0, ctx);
  const auto rings = walls(paths);
  REQUIRE(rings.size() == 10);
  for (std::size_t k = 0; k < rings.size(); ++k) {
    CHECK(rings[k]->closed);
    // All but the innermost ring keep their place exactly; the innermost takes up what is left.
    if (k + 1 == rings.size()) continue;
    for (Eigen::Index i = 0; i < rings[k]->points.rows(); ++i)
      CHECK(std::abs(rings[k]->points.row(i).norm() - (9.7 - static_cast<double>(k))) < 0.035);
  }
  CHECK(share(paths.covered_area, paths.area) > 99);
  CHECK(share(paths.overlap_area, paths.wide_area) < 2);
  CHECK(covered_share(make_disc(10.2, 0.7), paths, 0.1) > 99);
}

TEST_CASE("layers of many shapes are covered, laid once, and filled with their own volume") {
  struct Case {
    const char* name;
    Layer layer;
  };
  const Case cases[] = {{"annulus", make_annulus(4, 10.3, 0.7)},
                        {"square with hole", make_square_with_hole(20, 8.6, 0.7)},
                        {"rectangle, 4.3 beads", make_rectangle(20, 4.3, 0.7)},
                        {"rectangle, 4.8 beads", make_rectangle(20, 4.8, 0.7)},
                        {"rectangle, 5.4 beads", make_rectangle(20, 5.4, 0.7)},
                        {"strip, 0.7 beads", make_rectangle(20, 0.7, 0.7)},
                        {"strip, 1.5 beads", make_rectangle(20, 1.5, 0.7)},
                        {"strip, 2.5 beads", make_rectangle(20, 2.5, 0.7)},
                        {"two lobes and a neck", make_lobes(0.7)},
                        {"cap", make_cap(12, 12, 0.7)}};
  Context ctx;
  for (const Case& c : cases) {
    CAPTURE(c.name);
    const LayerPaths paths = contour_parallel(c.layer, 1.0, ctx);
    CHECK(share(paths.covered_area, paths.area) > 97);
    CHECK(share(paths.overlap_area, paths.wide_area) < 5);
    CHECK(bead_area(paths) / paths.area == doctest::Approx(1).epsilon(0.06));
    CHECK(paths.unfilled_thin_area < 0.01 * paths.area);
    if (c.layer.surface.triangles.rows() < 1000)
      CHECK(covered_share(c.layer, paths, 0.1) ==
            doctest::Approx(share(paths.covered_area, paths.area)).epsilon(0.01));
  }
}

TEST_CASE("a strip too thin for a bead is listed, not dropped in silence") {
  Context ctx;
  const LayerPaths paths = contour_parallel(make_rectangle(20, 0.3, 0.3), 1.0, ctx);
  CHECK(paths.paths.empty());
  CHECK(paths.unfilled_thin_area == doctest::Approx(6.0));
  LayerStack stack;
  stack.layers = {make_disc(5, 0.7)};
  make_toolpaths(stack, nullptr, {}, 1.0, ctx);
  CHECK(ctx.warnings.empty());
  stack.layers.push_back(make_rectangle(20, 0.3, 0.3));
  make_toolpaths(stack, nullptr, {}, 1.0, ctx);
  REQUIRE(ctx.warnings.size() == 1);
  CHECK(ctx.warnings[0].code == "toolpaths.thin_area");
}

TEST_CASE("a strip of 1.4 beads gets one wide bead, a strip of three a ring with a bead inside") {
  Context ctx;
  const LayerPaths one = contour_parallel(make_rectangle(20, 1.4, 0.7), 1.0, ctx);
  REQUIRE(one.paths.size() == 1);
  CHECK(one.paths[0].kind == PathKind::gap_fill);
  CHECK(one.paths[0].width.maxCoeff() == doctest::Approx(1.4).epsilon(0.01));
  const LayerPaths three = contour_parallel(make_rectangle(20, 3.0, 0.7), 1.0, ctx);
  REQUIRE(three.paths.size() == 2);
  CHECK(three.paths[0].kind == PathKind::wall);
  CHECK(three.paths[1].kind == PathKind::gap_fill);
}

TEST_CASE("spacing on a spherical cap is geodesic") {
  Context ctx;
  const double sphere = 12;
  const LayerPaths paths = contour_parallel(make_cap(sphere, 14, 0.7), 1.0, ctx);
  const auto rings = walls(paths);
  REQUIRE(rings.size() >= 13);
  for (std::size_t k = 0; k < 13; ++k)
    for (Eigen::Index i = 0; i < rings[k]->points.rows(); ++i) {
      const Vec3 p = rings[k]->points.row(i);
      const double arc = sphere * std::atan2(std::hypot(p.x(), p.y()), sphere + p.z());
      CHECK(std::abs(arc - (13.5 - static_cast<double>(k))) < 0.04);
    }
}

TEST_CASE("paths scale with the layer") {
  Context ctx;
  Layer small = make_lobes(0.7), large = make_lobes(0.7);
  large.surface.vertices *= 10;
  large.thickness *= 10;
  large.bead_height *= 10;
  const LayerPaths a = contour_parallel(small, 1.0, ctx), b = contour_parallel(large, 10.0, ctx);
  REQUIRE(a.paths.size() == b.paths.size());
  CHECK(b.covered_area == doctest::Approx(100 * a.covered_area).epsilon(0.002));
  CHECK(bead_area(b) == doctest::Approx(100 * bead_area(a)).epsilon(0.002));
}

TEST_CASE("toolpaths do not depend on the number of threads") {
  LayerStack stack;
  for (int i = 0; i < 5; ++i) stack.layers.push_back(make_lobes(0.7));
  stack.layers.push_back(make_disc(5, 0.7));
  const auto run = [&](int threads) {
    Context ctx(threads);
    return make_toolpaths(stack, nullptr, {}, 1.0, ctx);
  };
  const Toolpaths one = run(1), three = run(3);
  REQUIRE(one.layers.size() == three.layers.size());
  for (std::size_t i = 0; i < one.layers.size(); ++i) {
    REQUIRE(one.layers[i].paths.size() == three.layers[i].paths.size());
    CHECK(one.layers[i].covered_area == three.layers[i].covered_area);
    for (std::size_t k = 0; k < one.layers[i].paths.size(); ++k)
      CHECK(one.layers[i].paths[k].points == three.layers[i].paths[k].points);
  }
}

TEST_CASE("a bead width that is not positive is the user's error") {
  Context ctx;
  CHECK_THROWS_AS(make_toolpaths({}, nullptr, {}, 0.0, ctx), Error);
}
