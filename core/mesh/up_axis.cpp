#include "mesh/up_axis.h"

#include <cmath>
#include <string>

namespace s3 {

namespace {

constexpr double kFlat = 1e-3;  // as for the plate: of the height above it, and of the normal
// Shares of the surface: less than the first is no stand, more than the second is one.
constexpr double kNoStand = 1e-3, kStand = 1e-2;

/// Area of the faces that lie on the model's lowest plane along an axis and face down, mm².
double stand_area(const TriMesh& surface, const Box& box, int axis) {
  const double limit = box.min[axis] + kFlat * (box.max[axis] - box.min[axis]);
  double area = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corners = surface.triangles.row(f);
    bool low = true;
    for (int i = 0; i < 3; ++i) low = low && surface.vertices(corners[i], axis) <= limit;
    if (!low) continue;
    const Vec3 n = triangle_normal_2a(surface.vertices, corners);
    if (n[axis] < (kFlat - 1) * n.norm()) area += 0.5 * n.norm();
  }
  return area;
}

}  // namespace

void warn_about_up_axis(const TriMesh& surface, const InputParams& params, Context& ctx) {
  if (params.rotate != InputParams().rotate) return;
  const Box box = bounding_box(surface.vertices);
  const double whole = surface_area(surface);
  const bool z_up = params.up == "z";
  const double taken = stand_area(surface, box, z_up ? 2 : 1),
               other = stand_area(surface, box, z_up ? 1 : 2);
  if (taken >= kNoStand * whole || other <= kStand * whole) return;
  const std::string up = z_up ? "y" : "z";
  ctx.warn("mesh.up_axis",
           "nothing of the model lies flat on the plate with " + params.up + " up, but " +
               std::to_string(std::lround(100 * other / whole)) + " % of its surface would with " +
               up + " up; if it lies on its side, set input.up " + up + " or input.rotate auto");
}

}  // namespace s3
