#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "base/error.h"
#include "base/units.h"
#include "grid_mesh.h"
#include "layers/adaptive_slicing.h"
#include "layers/layer_distance.h"
#include "layers/remesh.h"
#include "layers/trim_to_range.h"

using namespace s3;

namespace {

LayerStack slice(const TetMesh& mesh, const Values& g, const LayerParams& params = {},
                 int threads = 1) {
  Context ctx(threads);
  return make_layers(mesh, make_scalar_field(mesh, g), params, ctx);
}

ThicknessReport measure(const LayerStack& stack, double d_min = 0.4, double d_max = 1.0) {
  Context ctx;
  return measure_thickness(stack, d_min, d_max, ctx);
}

// Keeps the tets whose centroid satisfies the predicate.
template <class Predicate>
TetMesh filter(const TetMesh& mesh, Predicate&& keep) {
  std::vector<Index> kept;
  for (Index t = 0; t < mesh.tet_count(); ++t)
    if (keep(mesh.centroid(t))) kept.push_back(t);
  std::vector<Index> number(static_cast<std::size_t>(mesh.vertex_count()), -1), used;
  Tets tets(static_cast<Eigen::Index>(kept.size()), 4);
  for (std::size_t k = 0; k < kept.size(); ++k)
    for (int i = 0; i < 4; ++i) {
      const Index v = mesh.tets(kept[k], i);
      if (number[v] < 0) {
        number[v] = static_cast<Index>(used.size());
        used.push_back(v);
      }
      tets(static_cast<Eigen::Index>(k), i) = number[v];
    }
  Points vertices(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v)
    vertices.row(static_cast<Eigen::Index>(v)) = mesh.vertices.row(used[v]);
  return make_tet_mesh(vertices, tets);
}

void check_sound(const LayerStack& stack) {
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const Layer& layer = stack.layers[k];
    CHECK(layer.normal.rows() == layer.surface.vertices.rows());
    CHECK(layer.thickness.size() == layer.surface.vertices.rows());
    CHECK(layer.source_tet.size() == static_cast<std::size_t>(layer.surface.triangles.rows()));
    std::map<std::pair<Index, Index>, int> directed;
    int repeated = 0, against_normal = 0;
    for (Eigen::Index f = 0; f < layer.surface.triangles.rows(); ++f) {
      const Vec3 n = triangle_normal_2a(layer.surface.vertices, layer.surface.triangles.row(f));
      for (int i = 0; i < 3; ++i) {
        repeated +=
            ++directed[{layer.surface.triangles(f, i), layer.surface.triangles(f, (i + 1) % 3)}] >
            1;
        against_normal += n.dot(layer.normal.row(layer.surface.triangles(f, i))) < 0;
      }
    }
    CHECK(repeated == 0);
    CHECK(against_normal == 0);
    for (const Index below : layer.rests_on) {
      CHECK(below < static_cast<Index>(k));
      CHECK(stack.layers[below].layer < layer.layer);
    }
  }
}

double bead_volume(const LayerStack& stack) {
  double volume = 0;
  for (const Layer& layer : stack.layers)
    for (Eigen::Index f = 0; f < layer.surface.triangles.rows(); ++f) {
      const auto corners = layer.surface.triangles.row(f);
      const double third = triangle_normal_2a(layer.surface.vertices, corners).norm() / 6;
      for (int i = 0; i < 3; ++i) volume += third * layer.bead_height(corners(i));
    }
  return volume;
}

}  // namespace

TEST_CASE("planar layers of a box have its height, area and thickness") {
  const TetMesh box = test::make_grid(4, 4, 4, Vec3(8, 8, 8));
  Context ctx;
  const LayerStack stack = make_planar_layers(box, 0.8, {}, ctx);
  REQUIRE(stack.layers.size() == 10);
  for (const Layer& layer : stack.layers) {
    CHECK(surface_area(layer.surface) == doctest::Approx(64).epsilon(2e-3));
    CHECK(layer.thickness.minCoeff() == doctest::Approx(0.8).epsilon(2e-3));
    CHECK(layer.thickness.maxCoeff() == doctest::Approx(0.8).epsilon(2e-3));
    CHECK(layer.normal.col(2).minCoeff() == doctest::Approx(1));
  }
}

TEST_CASE("a thickness range that is too narrow is refused") {
  const TetMesh box = test::make_grid(1, 1, 1, Vec3(2, 2, 2));
  LayerParams params;
  params.min_thickness = 0.9;
  CHECK_THROWS_AS(slice(box, box.vertices.col(2), params), Error);
}

TEST_CASE("a part lower than the thinnest layer is refused") {
  const TetMesh box = test::make_grid(2, 2, 1, Vec3(2, 2, 0.2));
  CHECK_THROWS_AS(slice(box, box.vertices.col(2)), Error);
}

TEST_CASE("adaptive layers of a box under its height are as few as fit and end at its top") {
  const TetMesh box = test::make_grid(5, 5, 5, Vec3(10, 10, 10));
  const LayerStack stack = slice(box, box.vertices.col(2));
  check_sound(stack);
  CHECK(stack.layers.size() == 11);  // 10 mm in layers of at most 1 mm less the reserve
  CHECK(stack.layers.back().surface.vertices.col(2).minCoeff() ==
        doctest::Approx(10).epsilon(1e-3));
  const ThicknessReport report = measure(stack);
  CHECK(report.outside_percent() == 0);
  CHECK(report.min > 0.8);
  CHECK(report.area == doctest::Approx(1100).epsilon(2e-3));
  for (std::size_t k = 1; k < stack.layers.size(); ++k)
    CHECK(stack.layers[k].rests_on == std::vector<Index>{static_cast<Index>(k - 1)});
}

TEST_CASE(
    "where the spacing of isosurfaces varies fourfold partial layers keep the thickness in range") {
  const TetMesh box = test::make_grid(16, 6, 12, Vec3(24, 8, 12));
  Values g(box.vertex_count());
  for (Index v = 0; v < box.vertex_count(); ++v)
    g(v) = box.vertices(v, 2) * (1 + 0.6 * (box.vertices(v, 0) - 12) / 12);
  const LayerStack stack = slice(box, g);
  check_sound(stack);
  CHECK(std::any_of(stack.layers.begin(), stack.layers.end(),
                    [](const Layer& l) { return l.partial; }));
  const ThicknessReport report = measure(stack);
  CHECK(report.outside_percent() == 0);
  CHECK(report.min >= 0.4);
  CHECK(report.max <= 1.0);
  CHECK(stack.unsupported_area == 0);
}

TEST_CASE("where the spacing of isosurfaces varies in waves partial layers stay whole") {
  // Left to themselves, places of different spacing lose step with each other and fall apart:
  // without halving, 271 pieces that hold 89 % of the volume.
  const TetMesh box = test::make_grid(12, 12, 14, Vec3(16, 16, 12));
  Values g(box.vertex_count());
  for (Index v = 0; v < box.vertex_count(); ++v) {
    const auto wave = [&](int axis) { return std::sin(2 * kPi * box.vertices(v, axis) / 16); };
    g(v) = box.vertices(v, 2) * (1 + 0.5 * wave(0) * wave(1));
  }
  const LayerStack stack = slice(box, g);
  check_sound(stack);
  CHECK(measure(stack).outside_percent() < 0.01);
  CHECK(stack.layers.size() < 80);
  CHECK(bead_volume(stack) == doctest::Approx(tet_volumes(box).sum()).epsilon(0.04));
}

TEST_CASE("a top beside a tower gets a layer of its own where there is room for it") {
  for (const double step : {6.6, 6.1}) {
    const TetMesh part = filter(test::make_grid(8, 8, 20, Vec3(10, 10, 2 * step)),
                                [&](const Vec3& c) { return c.x() < 5 || c.z() < step; });
    const LayerStack stack = slice(part, part.vertices.col(2));
    check_sound(stack);
    CHECK(measure(stack).outside_percent() == 0);
    const auto ends_at_top = [&](const Layer& l) {
      return l.partial && l.surface.vertices.col(2).maxCoeff() > step - 0.05 &&
             l.surface.vertices.col(2).maxCoeff() <= step &&
             l.surface.vertices.col(0).maxCoeff() > 9.9;
    };
    const auto found = std::find_if(stack.layers.begin(), stack.layers.end(), ends_at_top);
    double last = 0;  // of the complete layers below the top
    for (const Layer& l : stack.layers)
      if (!l.partial && l.iso_value < step) last = std::max(last, l.iso_value);
    CAPTURE(last);
    CHECK((found != stack.layers.end()) == (step - last > 0.42));
    if (found == stack.layers.end()) continue;
    // All of it but a seam beside the layer that the tower has above.
    CHECK(surface_area(found->surface) > 38);
    CHECK(surface_area(found->surface) < 51);
  }
}

TEST_CASE("a wall that overhangs by 45 degrees gets layers whose rims stay in reach") {
  const TetMesh block = test::make_grid(
      6, 6, 6, Vec3(9, 9, 9), [](const Vec3& p) { return Vec3(p.x() + p.z(), p.y(), p.z()); });
  const LayerStack stack = slice(block, block.vertices.col(2));
  check_sound(stack);
  const ThicknessReport report = measure(stack);
  CHECK(report.outside_percent() == 0);
  CHECK(report.p50 < 0.72);  // √2 times the layer height must stay below 1 mm
  CHECK(stack.unsupported_area == 0);
}

TEST_CASE("a gap that fronts close is left open until the layers reach over it") {
  // A slot 4 mm wide and 6 mm high through a block: half of it is more than d_max from its walls.
  const TetMesh block = filter(test::make_grid(18, 5, 14, Vec3(18, 10, 14)),
                               [](const Vec3& c) { return std::abs(c.x() - 9) > 2 || c.z() > 6; });
  Context ctx;
  const LayerStack stack =
      make_layers(block, make_scalar_field(block, block.vertices.col(2)), {}, ctx);
  check_sound(stack);
  const ThicknessReport report = measure(stack);
  CHECK(report.outside_percent() == 0);
  CHECK(stack.unsupported_area == 0);
  // The first layer over the slot lacks at least the 2 mm × 10 mm in its middle.
  CHECK(stack.dropped_area > 15);
  CHECK(stack.dropped_area < 80);
  REQUIRE(!stack.dropped_places.empty());
  for (const Vec3& place : stack.dropped_places) {
    CHECK(std::abs(place.x() - 9) < 2);
    CHECK(place.z() > 6);
    CHECK(place.z() < 9);  // closed soon
  }
  CHECK(surface_area(stack.layers.back().surface) == doctest::Approx(180).epsilon(0.01));
  CHECK(std::any_of(ctx.warnings.begin(), ctx.warnings.end(),
                    [](const Warning& w) { return w.code == "layers.dropped"; }));
}

TEST_CASE("what trimming leaves is in range at every corner, midpoint and centroid") {
  // The material is a ridge; the surface above is flat, 0.2 to 1.4 mm away.
  const TetMesh box = test::make_grid(12, 6, 4, Vec3(12, 6, 4));
  const ScalarField height = make_scalar_field(box, box.vertices.col(2));
  Values ridge(box.vertex_count());
  for (Index v = 0; v < box.vertex_count(); ++v)
    ridge(v) = box.vertices(v, 2) + 0.2 * std::abs(box.vertices(v, 0) - 6);
  const ScalarField tent = make_scalar_field(box, ridge);
  PrintedMaterial material;
  material.add(IsosurfaceExtractor(box, tent).extract(2.0).surface, 0);
  Isosurface surface = IsosurfaceExtractor(box, height).extract(2.2);
  Context ctx;
  const ThicknessRange range{0.4, 1.0, 0.41, 0.99, 4.0};
  Measured distance = measure(material, surface.surface.vertices, range.far(), ctx);
  REQUIRE(distance.thickness.minCoeff() < 0.4);
  REQUIRE(distance.thickness.maxCoeff() > 1.0);
  const double whole = surface_area(surface.surface);
  const Trimmed trimmed = trim_to_range(material, range, surface, distance, ctx);
  CHECK(distance.thickness.size() == surface.surface.vertices.rows());
  for (Eigen::Index f = 0; f < surface.surface.triangles.rows(); ++f) {
    Vec3 corner[3];
    for (int i = 0; i < 3; ++i)
      corner[i] = surface.surface.vertices.row(surface.surface.triangles(f, i));
    for (const Vec3& p : {corner[0], Vec3((corner[0] + corner[1]) / 2),
                          Vec3((corner[0] + corner[1] + corner[2]) / 3)}) {
      const double thickness = material.nearest(p, 10).distance;
      CHECK(thickness >= 0.4);
      CHECK(thickness <= 1.0);
    }
  }
  // 0.2 + 0.2 |x − 6| between 0.4 and 1.0, times cos of the slope 0.2, keeps |x − 6| in
  // [1.04, 4.1].
  CHECK(surface_area(surface.surface) == doctest::Approx(2 * 3.06 * 6).epsilon(0.06));
  CHECK(trimmed.left_out_area == doctest::Approx(2 * 1.9 * 6).epsilon(0.1));
  CHECK(surface_area(surface.surface) + trimmed.left_out_area < whole);
}

TEST_CASE("a slab that starts in the air is printed and reported with its area and place") {
  const TetMesh slab = filter(test::make_grid(10, 5, 10, Vec3(20, 10, 20)),
                              [](const Vec3& c) { return c.x() < 8 || c.z() > 12; });
  Context ctx;
  const LayerStack stack =
      make_layers(slab, make_scalar_field(slab, slab.vertices.col(2)), {}, ctx);
  // The underside is 12 mm × 10 mm; the millimetre next to the column is within reach.
  CHECK(stack.unsupported_area > 95);
  CHECK(stack.unsupported_area < 121);
  REQUIRE(stack.unsupported_places.size() == 1);
  CHECK(stack.unsupported_places[0].x() > 9);
  CHECK(std::any_of(ctx.warnings.begin(), ctx.warnings.end(),
                    [](const Warning& w) { return w.code == "layers.unsupported"; }));
}

TEST_CASE("two towers are separate components that rest on their own tower") {
  const TetMesh towers = filter(test::make_grid(10, 4, 6, Vec3(20, 8, 12)),
                                [](const Vec3& c) { return c.x() < 6 || c.x() > 14; });
  const LayerStack stack = slice(towers, towers.vertices.col(2));
  check_sound(stack);
  CHECK(stack.layers.size() == 2 * static_cast<std::size_t>(stack.isosurfaces));
  for (const Layer& layer : stack.layers)
    for (const Index below : layer.rests_on)
      CHECK((layer.surface.vertices(0, 0) < 10) ==
            (stack.layers[below].surface.vertices(0, 0) < 10));
}

TEST_CASE("a model ten times as large has the same layers, ten times as large") {
  const auto bend = [](double scale) { return [scale](const Vec3& p) { return Vec3(scale * p); }; };
  const TetMesh small = test::make_grid(8, 4, 8, Vec3(12, 6, 8), bend(1)),
                large = test::make_grid(8, 4, 8, Vec3(12, 6, 8), bend(10));
  const auto field = [](const TetMesh& mesh, double scale) {
    Values g(mesh.vertex_count());
    for (Index v = 0; v < mesh.vertex_count(); ++v)
      g(v) = mesh.vertices(v, 2) * (1 + 0.04 * mesh.vertices(v, 0) / scale);
    return g;
  };
  LayerParams params;
  params.nozzle_diameter = 10;
  const LayerStack a = slice(small, field(small, 1)), b = slice(large, field(large, 10), params);
  REQUIRE(a.layers.size() == b.layers.size());
  for (std::size_t k = 0; k < a.layers.size(); ++k) {
    CHECK(b.layers[k].iso_value == doctest::Approx(10 * a.layers[k].iso_value));
    CHECK(surface_area(b.layers[k].surface) ==
          doctest::Approx(100 * surface_area(a.layers[k].surface)));
    CHECK(b.layers[k].thickness.mean() == doctest::Approx(10 * a.layers[k].thickness.mean()));
  }
}

TEST_CASE("layers do not depend on the number of threads") {
  const TetMesh box = test::make_grid(10, 4, 6, Vec3(15, 6, 8));
  Values g(box.vertex_count());
  for (Index v = 0; v < box.vertex_count(); ++v)
    g(v) = box.vertices(v, 2) * (1 + 0.08 * box.vertices(v, 0));
  const LayerStack one = slice(box, g, {}, 1), three = slice(box, g, {}, 3);
  REQUIRE(one.layers.size() == three.layers.size());
  for (std::size_t k = 0; k < one.layers.size(); ++k) {
    CHECK(one.layers[k].surface.vertices == three.layers[k].surface.vertices);
    CHECK(one.layers[k].thickness == three.layers[k].thickness);
  }
}

TEST_CASE("a cancelled context stops the slicing") {
  const TetMesh box = test::make_grid(4, 4, 4, Vec3(8, 8, 8));
  Context ctx;
  ctx.cancel_requested = true;
  CHECK_THROWS_AS(make_layers(box, make_scalar_field(box, box.vertices.col(2)), {}, ctx),
                  Cancelled);
}

TEST_CASE("a remeshed sphere stays on the sphere, closed, with even triangles") {
  const TetMesh box = test::make_grid(24, 24, 24, Vec3(12, 12, 12));
  const Vec3 center(6.1, 5.9, 6.05);
  Values distance(box.vertex_count());
  for (Index v = 0; v < box.vertex_count(); ++v)
    distance(v) = (box.vertices.row(v).transpose() - center).norm();
  const ScalarField field = make_scalar_field(box, distance);
  IsosurfaceExtractor extractor(box, field);
  Context ctx;
  const Isosurface raw = extractor.extract(5.0), even = remesh(raw, {0.5, 0.02}, ctx);
  const AabbTree tree(raw.surface);
  double deviation = 0, mean_angle = 0;
  for (Eigen::Index f = 0; f < even.surface.triangles.rows(); ++f) {
    Vec3 corner[3];
    for (int i = 0; i < 3; ++i) corner[i] = even.surface.vertices.row(even.surface.triangles(f, i));
    deviation = std::max(deviation, tree.closest((corner[0] + corner[1] + corner[2]) / 3).distance);
    double least = 4;
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = corner[(i + 1) % 3] - corner[i], b = corner[(i + 2) % 3] - corner[i];
      least = std::min(least, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
    mean_angle += least / static_cast<double>(even.surface.triangles.rows());
  }
  CHECK(deviation < 0.02);  // 2 % of a 1 mm layer
  CHECK(mean_angle > 0.7);  // 40°; equilateral triangles have 60°
  CHECK(even.surface.vertices.rows() - even.surface.triangles.rows() / 2 == 2);
  for (Eigen::Index v = 0; v < even.normal.rows(); ++v)
    CHECK(even.normal.row(v).dot((even.surface.vertices.row(v).transpose() - center).normalized()) >
          0.98);
}
