#include "mesh/reorder.h"

#include <doctest/doctest.h>

#include "grid_mesh.h"

using namespace s3;

TEST_CASE("reordering keeps every tet at its place, and says where it came from") {
  const TetMesh mesh = test::make_grid(5, 4, 3, Vec3(5, 4, 3));
  std::vector<Index> vertex_order, tet_order;
  const TetMesh ordered = reorder_along_morton(mesh, &vertex_order, &tet_order);
  REQUIRE(ordered.tet_count() == mesh.tet_count());
  REQUIRE(ordered.vertex_count() == mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    CHECK(ordered.vertices.row(v) == mesh.vertices.row(vertex_order[static_cast<std::size_t>(v)]));
  for (Index t = 0; t < mesh.tet_count(); ++t)
    for (int i = 0; i < 4; ++i)
      CHECK(ordered.corner(t, i) == mesh.corner(tet_order[static_cast<std::size_t>(t)], i));
  CHECK(ordered.face_pairs.rows() == mesh.face_pairs.rows());
  CHECK(tet_volumes(ordered).sum() == doctest::Approx(60));
}
