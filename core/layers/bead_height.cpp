#include "layers/bead_height.h"

#include <algorithm>

namespace s3 {
namespace {

// Rays start this share of d_max below the layer: its boundary may stand off the part's surface by
// the tolerance of remeshing.
constexpr double kStart = 0.05;

}  // namespace

Values bead_heights(const PrintedMaterial& material, const AabbTree& part, const TriMesh& layer,
                    const Directions& normal, double d_min, double d_max, Context& ctx) {
  const auto faces = static_cast<std::size_t>(layer.triangles.rows());
  Values under(layer.triangles.rows()), area(layer.triangles.rows());
  parallel_for(ctx.pool, faces, 128, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto f = static_cast<Eigen::Index>(i);
      const auto corners = layer.triangles.row(f);
      const Vec3 down = -(normal.row(corners(0)) + normal.row(corners(1)) + normal.row(corners(2)))
                             .transpose()
                             .normalized();
      const double start = kStart * d_max;
      const Vec3 from = (layer.vertices.row(corners(0)) + layer.vertices.row(corners(1)) +
                         layer.vertices.row(corners(2)))
                                .transpose() /
                            3 +
                        start * down;
      const double printed = material.along(from, down, d_max - start);
      const double height = start + std::min(printed, part.first_hit(from, down, printed).t);
      area(f) = triangle_normal_2a(layer.vertices, corners).norm() / 2;
      under(f) = std::clamp(height, d_min, d_max);
    }
  });
  Values sum = Values::Zero(layer.vertices.rows()), weight = sum;
  for (Eigen::Index f = 0; f < layer.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      sum(layer.triangles(f, i)) += area(f) * under(f);
      weight(layer.triangles(f, i)) += area(f);
    }
  for (Eigen::Index v = 0; v < sum.size(); ++v)
    sum(v) = weight(v) > 0 ? std::clamp(sum(v) / weight(v), d_min, d_max) : d_min;
  return sum;
}

}  // namespace s3
