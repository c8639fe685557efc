#include <doctest/doctest.h>

#include <cmath>

#include "base/units.h"
#include "layer_shapes.h"
#include "toolpaths/make_toolpaths.h"
#include "waypoints/make_waypoints.h"

using namespace s3;
using namespace s3::test;

namespace {

/// Flat layers of one shape, `thickness` apart.
LayerStack make_stack(const Layer& shape, int layers, double thickness) {
  LayerStack stack;
  for (int i = 0; i < layers; ++i) {
    Layer layer = shape;
    layer.surface.vertices.col(2).array() += (i + 1) * thickness;
    layer.thickness.setConstant(thickness);
    layer.bead_height = layer.thickness;
    layer.layer = i;
    stack.layers.push_back(std::move(layer));
  }
  return stack;
}

}  // namespace

TEST_CASE("the extruded volume is that of the layers") {
  Context ctx;
  for (const Layer& shape :
       {make_disc(10.3, 0.7), make_square_with_hole(20, 8.6, 0.7), make_rectangle(20, 2.5, 0.7)}) {
    const LayerStack stack = make_stack(shape, 3, 0.5);
    const Toolpaths paths = make_toolpaths(stack, nullptr, {}, 1.0, ctx);
    const Waypoints w = make_waypoints(stack, paths, {}, ctx);
    double volume = 0, area = 0;
    for (Index i = 0; i < w.size(); ++i) volume += w.extrusion(i) * kPi / 4 * 1.75 * 1.75;
    for (const LayerPaths& layer : paths.layers) area += layer.area;
    CHECK(volume == doctest::Approx(area * 0.5).epsilon(0.03));
  }
}

TEST_CASE("waypoints keep distance, corners and the layer's normal") {
  Context ctx;
  LayerStack stack;
  stack.layers = {make_cap(12, 8, 0.7)};
  WaypointSettings settings;
  settings.spacing = 1.0;
  const Toolpaths paths = make_toolpaths(stack, nullptr, {}, 1.0, ctx);
  const Waypoints w = make_waypoints(stack, paths, settings, ctx);
  REQUIRE(w.size() > 100);
  for (Index i = 0; i < w.size(); ++i) {
    CHECK(w.normal.row(i).norm() == doctest::Approx(1));
    CHECK(w.tangent.row(i).norm() == doctest::Approx(1));
    CHECK(std::abs(w.normal.row(i).dot(w.tangent.row(i))) < 1e-9);
    if (w.travel[static_cast<std::size_t>(i)]) {
      CHECK(w.extrusion(i) == 0);
      continue;
    }
    const Vec3 p = w.position.row(i);
    CHECK((p - Vec3(w.position.row(i - 1))).norm() < 1.0 + 1e-9);
    CHECK(w.extrusion(i) > 0);
    // On the sphere of radius 12 about (0, 0, −12).
    CHECK((p + Vec3(0, 0, 12)).norm() == doctest::Approx(12).epsilon(0.002));
    CHECK((p + Vec3(0, 0, 12)).normalized().dot(w.normal.row(i)) > 0.999);
  }
}

TEST_CASE("closed paths end where they begin") {
  Context ctx;
  LayerStack stack;
  stack.layers = {make_annulus(4, 8, 0.7)};
  const Waypoints w = make_waypoints(stack, make_toolpaths(stack, nullptr, {}, 1.0, ctx), {}, ctx);
  int closed = 0;
  for (Index i = 0; i < w.size();) {
    Index last = i;
    while (last + 1 < w.size() &&
           w.path[static_cast<std::size_t>(last + 1)] == w.path[static_cast<std::size_t>(i)] &&
           !(w.travel[static_cast<std::size_t>(last + 1)] &&
             !w.travel[static_cast<std::size_t>(last)]))
      ++last;
    Index first = i;
    while (first < last && w.travel[static_cast<std::size_t>(first + 1)]) ++first;
    if (w.kind[static_cast<std::size_t>(i)] == PathKind::wall && first < last) {
      CHECK((w.position.row(first) - w.position.row(last)).norm() < 1e-9);
      ++closed;
    }
    i = last + 1;
  }
  CHECK(closed == 4);
}

TEST_CASE("thick beads are printed slower so that the hot end keeps up") {
  Context ctx;
  const LayerStack stack = make_stack(make_disc(6, 0.7), 1, 0.8);
  WaypointSettings settings;
  settings.print_speed = 30;
  settings.max_flow = 8;
  const Waypoints w =
      make_waypoints(stack, make_toolpaths(stack, nullptr, {}, 1.0, ctx), settings, ctx);
  for (Index i = 1; i < w.size(); ++i) {
    if (w.travel[static_cast<std::size_t>(i)]) continue;
    const double length = (w.position.row(i) - w.position.row(i - 1)).norm();
    const double flow = w.extrusion(i) * kPi / 4 * 1.75 * 1.75 / length * w.speed(i);
    CHECK(flow < 8.0001);
    CHECK(w.speed(i) <= 30);
  }
}

TEST_CASE("travels clear a printed tower that stands between two pads") {
  Context ctx;
  // A tower of 20 layers first, then pads on its two sides, printed one after the other.
  LayerStack stack = make_stack(make_rectangle(6, 6, 0.75), 20, 0.5);
  for (int i = 0; i < 4; ++i)
    for (const double side : {-12.0, 12.0}) {
      Layer pad = make_rectangle(4, 4, 0.66);
      pad.surface.vertices.col(0).array() += side;
      pad.surface.vertices.col(2).array() += 0.5 * (i + 1);
      stack.layers.push_back(pad);
    }
  const Toolpaths toolpaths = make_toolpaths(stack, nullptr, {}, 1.0, ctx);
  ctx.warnings.clear();  // the corners of the small pads are too thin for a bead
  const Waypoints w = make_waypoints(stack, toolpaths, {}, ctx);
  CHECK(ctx.warnings.empty());
  int crossings = 0;
  for (Index i = 1; i < w.size(); ++i) {
    if (!w.travel[static_cast<std::size_t>(i)] || w.component[static_cast<std::size_t>(i)] <= 20)
      continue;
    const Vec3 a = w.position.row(i - 1), b = w.position.row(i);
    for (int k = 0; k <= 50; ++k) {
      const Vec3 p = a + (b - a) * (k / 50.0);
      if (std::abs(p.x()) < 3 && std::abs(p.y()) < 3) {
        CHECK(p.z() > 10.5);
        ++crossings;
      }
      CHECK(p.z() > 0.499);
    }
  }
  CHECK(crossings > 0);
}
