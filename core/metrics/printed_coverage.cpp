#include "metrics/printed_coverage.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "mesh/surface_samples.h"
#include "metrics/tube_grid.h"

namespace s3 {
namespace {

/// The beads of every isosurface: tubes on the layer as wide as the beads.
std::vector<std::vector<Tube>> beads_by_layer(const Waypoints& w, std::size_t layers) {
  std::vector<std::vector<Tube>> beads(layers);
  for (Index i = 1; i < w.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto layer = static_cast<std::size_t>(w.layer[at]);
    if (w.travel[at] || layer >= layers) continue;
    beads[layer].push_back({w.position.row(i - 1), w.position.row(i), w.width(i) / 2});
  }
  return beads;
}

}  // namespace

std::optional<double> printed_coverage_percent(const LayerStack& stack, const Waypoints& waypoints,
                                               double bead_width, Context& ctx) {
  std::size_t layers = 0;
  for (const Layer& layer : stack.layers)
    layers = std::max(layers, static_cast<std::size_t>(layer.layer) + 1);
  std::vector<std::vector<Tube>> beads = beads_by_layer(waypoints, layers);
  double area = 0, covered = 0;
  for (std::size_t number = 0; number < layers; ++number) {
    ctx.checkpoint();
    const bool empty = beads[number].empty();
    const TubeGrid grid(empty ? std::vector<Tube>{{Vec3::Zero(), Vec3::Zero(), 0}}
                              : std::move(beads[number]));
    for (const Layer& layer : stack.layers) {
      if (static_cast<std::size_t>(layer.layer) != number) continue;
      const double layer_area = surface_area(layer.surface);
      const double sample_distance = bead_width / 4;
      const Points samples =
          sample_surface(layer.surface, layer_area / (sample_distance * sample_distance) + 1);
      Eigen::Index inside = 0;
      for (Eigen::Index i = 0; i < samples.rows(); ++i)
        if (!empty && grid.signed_distance(samples.row(i)) <= 0) ++inside;
      area += layer_area;
      if (samples.rows() > 0)
        covered += layer_area * static_cast<double>(inside) / static_cast<double>(samples.rows());
    }
  }
  if (!(area > 0)) return std::nullopt;
  return 100 * covered / area;
}

}  // namespace s3
