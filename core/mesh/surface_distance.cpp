#include "mesh/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mesh/aabb_tree.h"
#include "mesh/surface_samples.h"

namespace s3 {

namespace {

constexpr std::size_t kChunk = 256;

struct Samples {
  Points points;
  std::vector<Index> triangles;
};

// Keeps the samples on the border of the solid: its inside on one side, its outside on the other.
// @return the share that was dropped
double keep_border(const TriMesh& mesh, const WindingNumber& solid, Samples& samples,
                   Context& ctx) {
  // How far from the surface both sides are asked, of the diagonal: small against any wall, large
  // against rounding.
  constexpr double kStep = 1e-6;
  const double step = kStep * bounding_box(mesh.vertices).diagonal();
  const auto n = static_cast<std::size_t>(samples.points.rows());
  std::vector<char> keep(n, 0);
  parallel_for(ctx.pool, n, kChunk, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 p = samples.points.row(static_cast<Eigen::Index>(i));
      const Vec3 normal =
          triangle_normal_2a(mesh.vertices, mesh.triangles.row(samples.triangles[i])).normalized();
      keep[i] = solid.is_inside(p + step * normal) != solid.is_inside(p - step * normal);
    }
  });
  Eigen::Index kept = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (keep[i]) samples.points.row(kept++) = samples.points.row(static_cast<Eigen::Index>(i));
  samples.points.conservativeResize(kept, 3);
  return n > 0 ? 1.0 - static_cast<double>(kept) / static_cast<double>(n) : 0.0;
}

DistanceFigures figures(const Points& samples, const AabbTree& tree, Context& ctx) {
  const auto n = static_cast<std::size_t>(samples.rows());
  if (n == 0 || tree.empty()) return {};
  std::vector<double> distances(n);
  parallel_for(ctx.pool, n, kChunk, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    for (std::size_t i = begin; i < end; ++i)
      distances[i] = tree.closest(samples.row(static_cast<Eigen::Index>(i))).distance;
  });
  DistanceFigures result;
  const auto farthest = std::max_element(distances.begin(), distances.end());
  result.max = *farthest;
  result.place = samples.row(farthest - distances.begin());
  for (const double d : distances) result.mean += d;
  result.mean /= static_cast<double>(n);
  const auto rank = static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(n - 1));
  std::nth_element(distances.begin(), distances.begin() + rank, distances.end());
  result.p95 = distances[static_cast<std::size_t>(rank)];
  return result;
}

}  // namespace

SurfaceDistance surface_distance(const TriMesh& made, const TriMesh& given,
                                 const WindingNumber* solid, Context& ctx, double samples) {
  SurfaceDistance result;
  if (!(surface_area(made) > 0) || !(surface_area(given) > 0)) return result;
  result.from_made = figures(sample_surface(made, samples), AabbTree(given), ctx);
  Samples back;
  back.points = sample_surface(given, samples, &back.triangles);
  if (solid) result.inner_share = keep_border(given, *solid, back, ctx);
  result.from_given = figures(back.points, AabbTree(made), ctx);
  return result;
}

}  // namespace s3
