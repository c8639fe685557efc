#include "metrics/print_metrics.h"

#include <cmath>

#include "base/units.h"

namespace s3 {
namespace {

/// Figures of all layers' lines together.
void line_metrics(const Toolpaths& toolpaths, Metrics& metrics) {
  ShareHistogram deviation, spacing;
  for (const LayerPaths& layer : toolpaths.layers) {
    deviation.add(layer.lines.deviation);
    spacing.add(layer.lines.spacing);
  }
  if (deviation.total() > 0)
    metrics.stress_deviation_deg = {.p50 = 90 * deviation.quantile(0.5),
                                    .p90 = 90 * deviation.quantile(0.9),
                                    .p99 = 90 * deviation.quantile(0.99)};
  if (spacing.total() > 0)
    metrics.line_spacing = {.p5 = 2 * spacing.quantile(0.05),
                            .p50 = 2 * spacing.quantile(0.5),
                            .p95 = 2 * spacing.quantile(0.95),
                            .within_15_percent = 100 * spacing.between(0.85 / 2, 1.15 / 2)};
}

}  // namespace

void toolpath_metrics(const Toolpaths& toolpaths, Metrics& metrics) {
  double length = 0, area = 0, covered = 0, overlap = 0, wide = 0;
  for (const LayerPaths& layer : toolpaths.layers) {
    area += layer.area;
    covered += layer.covered_area;
    overlap += layer.overlap_area;
    wide += layer.wide_area;
    for (const Path& path : layer.paths) {
      const Eigen::Index count = path.points.rows();
      for (Eigen::Index i = 1; i < count; ++i)
        length += (path.points.row(i) - path.points.row(i - 1)).norm();
      if (path.closed && count > 1)
        length += (path.points.row(0) - path.points.row(count - 1)).norm();
    }
  }
  line_metrics(toolpaths, metrics);
  metrics.path_length_mm = length;
  metrics.coverage_percent = area > 0 ? std::optional<double>(100 * covered / area) : std::nullopt;
  metrics.overlap_percent = wide > 0 ? std::optional<double>(100 * overlap / wide) : std::nullopt;
}

void waypoint_metrics(const Waypoints& waypoints, const MachineProfile& machine, Metrics& metrics) {
  double filament = 0, seconds = 0;
  for (Index i = 0; i < waypoints.size(); ++i) {
    filament += waypoints.extrusion(i);
    if (i == 0 || !(waypoints.speed(i) > 0)) continue;
    seconds +=
        (waypoints.position.row(i) - waypoints.position.row(i - 1)).norm() / waypoints.speed(i);
  }
  const double radius = machine.filament_diameter / 2;
  metrics.material_g = filament * kPi * radius * radius * machine.filament_density;
  metrics.print_time_s = seconds;
}

}  // namespace s3
