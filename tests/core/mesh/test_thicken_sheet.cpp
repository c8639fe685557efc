#include <doctest/doctest.h>
#include <cmath>
#include <numbers>

#include "mesh/thicken_sheet.h"
#include "mesh/validate.h"

using namespace s3;

namespace {

// A grid over [0, 1]², every second triangle turned over; place(u, v) puts it in space.
template <class Place>
TriMesh sheet(Index n, Place&& place) {
  TriMesh mesh;
  mesh.vertices.resize((n + 1) * (n + 1), 3);
  for (Index j = 0; j <= n; ++j)
    for (Index i = 0; i <= n; ++i)
      mesh.vertices.row(j * (n + 1) + i) = place(double(i) / n, double(j) / n);
  mesh.triangles.resize(2 * n * n, 3);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.row(2 * (j * n + i)) << a, b, d;
      mesh.triangles.row(2 * (j * n + i) + 1) << a, d, c;
      if ((i + j) % 2 == 0) mesh.triangles.row(2 * (j * n + i)) << a, d, b;
    }
  return mesh;
}

}  // namespace

TEST_CASE("a flat sheet becomes a box of its thickness") {
  const TriMesh plate =
      thicken_sheet(sheet(7, [](double u, double v) { return Vec3(10 * u, 5 * v, 3); }), 0.8);
  CHECK(inspect_surface(plate, nullptr).valid());
  CHECK(std::abs(enclosed_volume(plate)) == doctest::Approx(10 * 5 * 0.8));
  const Box box = bounding_box(plate.vertices);
  CHECK(box.min.isApprox(Vec3(0, 0, 2.6)));
  CHECK(box.max.isApprox(Vec3(10, 5, 3.4)));
}

TEST_CASE("a bent sheet becomes a shell with the sheet in its middle") {
  constexpr double kRadius = 20;
  const TriMesh shell = thicken_sheet(sheet(60,
                                            [](double u, double v) {
                                              const double angle = std::numbers::pi * u;
                                              return Vec3(kRadius * std::cos(angle), 30 * v,
                                                          kRadius * std::sin(angle));
                                            }),
                                      2);
  CHECK(inspect_surface(shell, nullptr).valid());
  CHECK(std::abs(enclosed_volume(shell)) ==
        doctest::Approx(std::numbers::pi * kRadius * 30 * 2).epsilon(0.002));
  for (Index v = 0; v < shell.vertices.rows(); ++v) {
    const double r = std::hypot(shell.vertices(v, 0), shell.vertices(v, 2));
    CHECK(std::min(std::abs(r - 19), std::abs(r - 21)) < 0.02);
  }
}
