#include "mesh/up_axis.h"

#include <doctest/doctest.h>

using namespace s3;

namespace {

// A pyramid on a square in the plane axis = 0, its tip at axis = 2.
TriMesh pyramid(int axis) {
  TriMesh mesh;
  mesh.vertices.resize(5, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 2;
  mesh.triangles.resize(6, 3);
  mesh.triangles << 0, 2, 1, 0, 3, 2, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4;
  const Points z_up = mesh.vertices;
  for (int k = 0; k < 3; ++k) mesh.vertices.col((k + axis + 1) % 3) = z_up.col(k);
  return mesh;
}

std::size_t warnings(const TriMesh& mesh, const InputParams& params) {
  Context ctx;
  warn_about_up_axis(mesh, params, ctx);
  if (!ctx.warnings.empty()) CHECK(ctx.warnings[0].code == "mesh.up_axis");
  return ctx.warnings.size();
}

}  // namespace

TEST_CASE("a model that stands with another axis up gets a warning") {
  CHECK(warnings(pyramid(2), {}) == 0);
  CHECK(warnings(pyramid(1), {}) == 1);
  CHECK(warnings(pyramid(1), {.up = "y"}) == 0);
  CHECK(warnings(pyramid(2), {.up = "y"}) == 1);
  CHECK(warnings(pyramid(0), {}) == 0);  // no axis to name
  CHECK(warnings(pyramid(1), {.rotate = "90,0,0"}) == 0);
}
