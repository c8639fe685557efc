#include <cmath>
#include <utility>

#include "base/units.h"
#include "mesh/surface_samples.h"
#include "metrics/print_metrics.h"
#include "metrics/tube_grid.h"

namespace s3 {
namespace {

/// One tube for each way that extrudes: round, with the area width × height of the bead, around its
/// centre line.
std::vector<Tube> make_tubes(const Waypoints& w) {
  const auto centre = [&](Index i, double height) -> Vec3 {
    return w.position.row(i) - height / 2 * w.normal.row(i);
  };
  std::vector<Tube> tubes;
  for (Index i = 1; i < w.size(); ++i) {
    if (w.travel[static_cast<std::size_t>(i)]) continue;
    const double height = w.height(i);
    tubes.push_back(
        {centre(i - 1, height), centre(i, height), std::sqrt(w.width(i) * height / kPi)});
  }
  return tubes;
}

}  // namespace

void surface_error(const TriMesh& surface, const Waypoints& waypoints, Metrics& metrics,
                   Context& ctx) {
  std::vector<Tube> tubes = make_tubes(waypoints);
  if (tubes.empty() || surface.triangles.rows() == 0) return;
  const TubeGrid grid(std::move(tubes));
  constexpr double kSamples = 100000;
  const Points samples = sample_surface(surface, kSamples);
  Values error(samples.rows());
  constexpr std::size_t kGrain = 2048;
  parallel_for(ctx.pool, static_cast<std::size_t>(samples.rows()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 ctx.checkpoint();
                 for (std::size_t i = begin; i < end; ++i) {
                   const auto row = static_cast<Eigen::Index>(i);
                   error(row) = std::abs(grid.signed_distance(samples.row(row)));
                 }
               });
  if (error.size() == 0) return;
  metrics.surface_error_avg_mm = error.mean();
  metrics.surface_error_max_mm = error.maxCoeff();
}

}  // namespace s3
