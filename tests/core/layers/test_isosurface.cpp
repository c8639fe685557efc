#include <doctest/doctest.h>

#include <map>

#include "grid_mesh.h"
#include "layers/isosurface.h"

using namespace s3;

namespace {

// Every edge belongs to one or two triangles, the two run through it in opposite directions.
bool is_manifold_and_oriented(const TriMesh& mesh) {
  std::map<std::pair<Index, Index>, int> directed;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i)
      if (++directed[{mesh.triangles(f, i), mesh.triangles(f, (i + 1) % 3)}] > 1) return false;
  return true;
}

}  // namespace

TEST_CASE(
    "a tilted plane through a box has the area of its cross-section and faces along the gradient") {
  const TetMesh box = test::make_grid(5, 4, 6, Vec3(10, 8, 12));
  const Vec3 direction = Vec3(0.3, 0.1, 1).normalized();
  const ScalarField field = make_scalar_field(box, box.vertices * direction);
  IsosurfaceExtractor extractor(box, field);
  const Isosurface iso = extractor.extract(6.0);
  CHECK(is_manifold_and_oriented(iso.surface));
  // The plane cuts the four vertical sides only: its area is that of the base over the cosine of
  // the tilt.
  CHECK(surface_area(iso.surface) == doctest::Approx(80 / direction.z()).epsilon(1e-3));
  const Directions normals = triangle_normals(iso.surface);
  for (Eigen::Index f = 0; f < normals.rows(); ++f)
    CHECK(normals.row(f).dot(direction) == doctest::Approx(1));
  for (Eigen::Index v = 0; v < iso.normal.rows(); ++v)
    CHECK(iso.normal.row(v).dot(direction) == doctest::Approx(1));
}

TEST_CASE("an iso value through vertices gives a manifold without degenerate triangles") {
  const TetMesh box = test::make_grid(3, 3, 3, Vec3(3, 3, 3));
  const ScalarField field = make_scalar_field(box, box.vertices.col(2));
  IsosurfaceExtractor extractor(box, field);
  for (const double shift : {-1e-12, 0.0, 1e-12}) {
    const Isosurface iso = extractor.extract(2.0 + shift);
    CHECK(is_manifold_and_oriented(iso.surface));
    CHECK(surface_area(iso.surface) == doctest::Approx(9).epsilon(1e-3));
    for (Eigen::Index f = 0; f < iso.surface.triangles.rows(); ++f)
      CHECK(triangle_normal_2a(iso.surface.vertices, iso.surface.triangles.row(f)).norm() > 0);
  }
}

TEST_CASE("the isosurface of the distance to a point inside the part is a closed sphere") {
  const TetMesh box = test::make_grid(12, 12, 12, Vec3(12, 12, 12));
  Values distance(box.vertex_count());
  for (Index v = 0; v < box.vertex_count(); ++v)
    distance(v) = (box.vertices.row(v).transpose() - Vec3(6.1, 5.9, 6.05)).norm();
  const ScalarField field = make_scalar_field(box, distance);
  IsosurfaceExtractor extractor(box, field);
  const Isosurface iso = extractor.extract(4.0);
  CHECK(is_manifold_and_oriented(iso.surface));
  CHECK(surface_area(iso.surface) == doctest::Approx(4 * 3.14159265 * 16).epsilon(0.03));
  CHECK(enclosed_volume(iso.surface) == doctest::Approx(4.0 / 3 * 3.14159265 * 64).epsilon(0.05));
  // Closed: Euler characteristic V − E + F = 2 with 2E = 3F.
  CHECK(iso.surface.vertices.rows() - iso.surface.triangles.rows() / 2 == 2);
}
