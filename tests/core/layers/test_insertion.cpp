#include "layers/insertion.h"

#include <doctest/doctest.h>

#include "grid_mesh.h"
#include "scalar_field/scalar_field.h"

using namespace s3;

namespace {

constexpr double kLength = 20, kWidth = 6;
const ThicknessRange kRange{0.4, 1.0, 0.41, 0.99, 4.0};

// A wedge whose top rises from `low` to `high` along x; G is 0 at its bottom and 1 at its top.
struct Wedge {
  double low, high;
  TetMesh part;
  ScalarField field;

  Wedge(double low_end, double high_end)
      : low(low_end),
        high(high_end),
        part(
            test::make_grid(40, 6, 4, Vec3(kLength, kWidth, 1),
                            [&](const Vec3& p) { return Vec3(p.x(), p.y(), p.z() * top(p.x())); })),
        field(make_scalar_field(part, height())) {}

  double top(double x) const { return low + (high - low) * x / kLength; }
  Values height() const {
    Values g(part.vertex_count());
    for (Index v = 0; v < part.vertex_count(); ++v)
      g(v) = part.vertices(v, 2) / top(part.vertices(v, 0));
    return g;
  }
  // What is inserted half-way below a layer at the top, or below the top alone.
  Isosurface inserted(bool layer_above, double least_area = 1) const {
    Context ctx;
    IsosurfaceExtractor extractor(part, field);
    const Isosurface middle = extractor.extract(0.5), above = extractor.extract(1 - 1e-6);
    const PrintedMaterial plate;
    LayersAbove layers;
    if (layer_above)
      layers.push(above.surface,
                  measure(plate, above.surface.vertices, kRange.far(), ctx).thickness);
    const Room room =
        measure_room(middle, measure(plate, middle.surface.vertices, kRange.far(), ctx), layers,
                     PartSurface(part), kRange, ctx);
    return insertion(middle, room, kRange, least_area);
  }
};

}  // namespace

TEST_CASE("a layer is inserted where the one above is beyond d_max, up to where it need not be") {
  const Wedge wedge(0.6, 1.6);
  const Isosurface piece = wedge.inserted(true);
  REQUIRE(piece.surface.triangles.rows() > 0);
  const double end = (0.94 - 0.6) * kLength;  // where the wedge is 0.94 mm high
  CHECK(piece.surface.vertices.col(0).minCoeff() == doctest::Approx(end).epsilon(0.01));
  CHECK(piece.surface.vertices.col(0).maxCoeff() == doctest::Approx(kLength));
  CHECK(surface_area(piece.surface) ==
        doctest::Approx((kLength - end) * kWidth * std::hypot(1, 0.025)).epsilon(0.01));
}

TEST_CASE("nothing is inserted where no span is beyond d_max") {
  CHECK(Wedge(0.6, 1.0).inserted(true).surface.triangles.rows() == 0);
  CHECK(Wedge(0.6, 1.0).inserted(false).surface.triangles.rows() == 0);
}

TEST_CASE("under a top that no layer reaches the rest of the part is the span") {
  const Isosurface piece = Wedge(0.6, 1.6).inserted(false);
  REQUIRE(piece.surface.triangles.rows() > 0);
  CHECK(piece.surface.vertices.col(0).minCoeff() ==
        doctest::Approx((0.94 - 0.6) * kLength).epsilon(0.02));
}

TEST_CASE("a small piece is not inserted") {
  // 12 mm × 6 mm are higher than 0.94 mm.
  const Wedge wedge(0.6, 1.45);
  CHECK(wedge.inserted(true, 70).surface.triangles.rows() > 0);
  CHECK(wedge.inserted(true, 75).surface.triangles.rows() == 0);
}

TEST_CASE("a way leaves a part at its surface, at once for points on it") {
  const TetMesh box = test::make_grid(4, 4, 4, Vec3(4, 4, 4));
  const PartSurface part(box);
  const Vec3 up(0, 0, 1);
  const auto leave = [&](const Vec3& p, const Vec3& direction, double reach) {
    return part.leave(p, direction, reach, 0.05);
  };
  CHECK(leave(Vec3(1.3, 2.1, 1), up, 10).distance == doctest::Approx(3));
  CHECK(leave(Vec3(1.3, 2.1, 1), up, 10).cosine == doctest::Approx(1));
  CHECK(leave(Vec3(1.3, 2.1, 1), up, 2).distance == 2);
  CHECK(leave(Vec3(1.3, 2.1, 1), up, 2).cosine == 0);
  for (const double off : {-0.02, 0.02}) {
    CHECK(leave(Vec3(1.3, 2.1, 4 + off), up, 10).distance < 0.021);                  // out
    CHECK(leave(Vec3(1.3, 2.1, off), up, 10).distance == doctest::Approx(4 - off));  // through
  }
}
