#include <doctest/doctest.h>

#include "base/error.h"
#include "grid_mesh.h"
#include "layers/adaptive_slicing.h"

using namespace s3;

TEST_CASE("planar layers of a box have its height, area and thickness") {
  const TetMesh box = test::make_grid(4, 4, 4, Vec3(8, 8, 8));
  Context ctx;
  const LayerStack stack = make_planar_layers(box, 0.8, {}, ctx);
  REQUIRE(stack.layers.size() == 10);
  for (std::size_t i = 0; i < stack.layers.size(); ++i) {
    const Layer& layer = stack.layers[i];
    CHECK(surface_area(layer.surface) == doctest::Approx(64).epsilon(2e-3));
    CHECK(layer.thickness.minCoeff() == doctest::Approx(0.8).epsilon(2e-3));
    CHECK(layer.thickness.maxCoeff() == doctest::Approx(0.8).epsilon(2e-3));
    CHECK(layer.normal.col(2).minCoeff() == doctest::Approx(1));
  }
}

TEST_CASE("a thickness range that is too narrow is refused") {
  const TetMesh box = test::make_grid(1, 1, 1, Vec3(2, 2, 2));
  Context ctx;
  LayerParams params;
  params.min_thickness = 0.9;
  CHECK_THROWS_AS(make_layers(box, make_scalar_field(box, box.vertices.col(2)), params, ctx),
                  Error);
}
