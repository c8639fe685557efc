#include <doctest/doctest.h>

#include <cmath>

#include "base/context.h"
#include "grid_mesh.h"
#include "layer_shapes.h"
#include "layers/adaptive_slicing.h"
#include "layers/bead_height.h"

using namespace s3;

namespace {

// A flat layer of 10 mm × 4 mm around the z axis.
Layer flat_at(double z) {
  Layer layer = test::make_rectangle(10, 4, 0.25);
  layer.surface.vertices.col(2).setConstant(z);
  return layer;
}

Values heights(const Layer& layer, const PrintedMaterial& material, const TriMesh& part) {
  Context ctx;
  return bead_heights(material, AabbTree(part), layer.surface, layer.normal, 0.4, 1.0, ctx);
}

// The right half of a layer.
TriMesh right_half(const Layer& layer) {
  TriMesh half;
  half.vertices = layer.surface.vertices;
  half.vertices.col(0) = 0.5 * half.vertices.col(0).array() + 2.5;
  half.triangles = layer.surface.triangles;
  return half;
}

// A box of 40 mm × 40 mm × 20 mm around the z axis: nothing ends inside it.
TriMesh wide_part() {
  TetMesh box = test::make_grid(1, 1, 1, Vec3(40, 40, 20));
  box.vertices.rowwise() -= Eigen::RowVector3d(20, 20, 0);
  return boundary_surface(box);
}

}  // namespace

TEST_CASE("beads beside the rim of a partial layer reach down to what lies under them") {
  PrintedMaterial material;
  material.add(right_half(flat_at(0.45)), 0);
  const Layer layer = flat_at(0.95);
  const Values height = heights(layer, material, wide_part());
  for (Eigen::Index v = 0; v < height.size(); ++v) {
    const double x = layer.surface.vertices(v, 0);
    if (x > 0.3) CHECK(height(v) == doctest::Approx(0.5));
    if (x < -0.3) CHECK(height(v) == doctest::Approx(0.95));  // the rim is 0.5 to 0.95 mm away
  }
}

TEST_CASE("no bead is higher than d_max, however deep it is below") {
  const Values height = heights(flat_at(7), PrintedMaterial(), wide_part());
  CHECK(height.minCoeff() == doctest::Approx(1.0));
  CHECK(height.maxCoeff() == doctest::Approx(1.0));
}

TEST_CASE("beads of an overhang end where the part does") {
  // A block whose left side leans outwards by 45°: at z = 5 it starts at x = −5.
  TetMesh block = test::make_grid(1, 1, 1, Vec3(40, 40, 20));
  for (Index v = 0; v < block.vertex_count(); ++v) {
    block.vertices(v, 1) -= 20;
    if (block.vertices(v, 0) == 0) block.vertices(v, 0) -= block.vertices(v, 2);
  }
  PrintedMaterial material;
  material.add(flat_at(4.3).surface, 0);  // ends at x = −5 too
  Layer layer = flat_at(5);
  const Values height = heights(layer, material, boundary_surface(block));
  for (Eigen::Index v = 0; v < height.size(); ++v) {
    const double x = layer.surface.vertices(v, 0), under = x + 5;
    if (std::abs(under - 0.7) < 0.3 || std::abs(under - 0.4) < 0.3) continue;
    CHECK(height(v) == doctest::Approx(std::clamp(under, 0.4, 0.7)));
  }
}

TEST_CASE("beads of all layers together are as large as the part") {
  // A tent of G, whose layers are partial: thickness alone misses the grooves beside their rims.
  const TetMesh block = test::make_grid(16, 6, 10, Vec3(24, 9, 15));
  Values g(block.vertex_count());
  for (Index v = 0; v < block.vertex_count(); ++v)
    g(v) = block.vertices(v, 2) * (1 + 0.06 * std::abs(block.vertices(v, 0) - 12));
  Context ctx;
  const LayerStack stack = make_layers(block, make_scalar_field(block, g), {}, ctx);
  double beads = 0, thickness = 0;
  for (const Layer& layer : stack.layers)
    for (Eigen::Index f = 0; f < layer.surface.triangles.rows(); ++f) {
      const auto corners = layer.surface.triangles.row(f);
      const double third = triangle_normal_2a(layer.surface.vertices, corners).norm() / 6;
      for (int i = 0; i < 3; ++i) {
        beads += third * layer.bead_height(corners(i));
        thickness += third * layer.thickness(corners(i));
      }
    }
  const double volume = tet_volumes(block).sum();
  CHECK(beads ==
        doctest::Approx(volume).epsilon(0.03));  // the top is thinner than a layer in places
  CHECK(std::abs(beads - volume) < std::abs(thickness - volume));
}
