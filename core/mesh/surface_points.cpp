#include "mesh/surface_points.h"

#include <cmath>
#include <cstdint>

namespace s3 {
namespace {

double van_der_corput(std::uint32_t bits) {
  double value = 0;
  for (double digit = 0.5; bits != 0; bits >>= 1, digit /= 2)
    if ((bits & 1u) != 0) value += digit;
  return value;
}

}  // namespace

std::vector<SurfacePoint> spread_points(const TriMesh& mesh, std::size_t count) {
  std::vector<SurfacePoint> points;
  const double total = surface_area(mesh);
  if (!(total > 0) || !std::isfinite(total)) return points;
  points.reserve(count);
  const double step = total / static_cast<double>(count);
  double passed = 0;  // area of the faces before f
  std::size_t k = 0;
  for (Eigen::Index f = 0; f < mesh.triangles.rows() && k < count; ++f) {
    const double area = 0.5 * triangle_normal_2a(mesh.vertices, mesh.triangles.row(f)).norm();
    for (std::uint32_t in_face = 1; k < count; ++in_face, ++k) {
      const double at = (static_cast<double>(k) + 0.5) * step;
      if (at >= passed + area) break;
      const double across = van_der_corput(in_face);
      const double along = std::sqrt((at - passed) / area);
      const auto corner = [&](int i) -> Vec3 { return mesh.vertices.row(mesh.triangles(f, i)); };
      points.push_back({corner(0) + along * ((1 - across) * (corner(1) - corner(0)) +
                                             across * (corner(2) - corner(0))),
                        static_cast<Index>(f)});
    }
    passed += area;
  }
  return points;
}

}  // namespace s3
