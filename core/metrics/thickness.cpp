#include "metrics/thickness.h"

#include "layers/layer_distance.h"

namespace s3 {

std::vector<WeightedValue> thickness_values(const LayerStack& stack) {
  std::vector<WeightedValue> values;
  for (const Layer& layer : stack.layers) {
    const std::size_t first = values.size();
    for (Eigen::Index v = 0; v < layer.surface.vertices.rows(); ++v)
      values.push_back({layer.thickness(v), 0});
    for (Eigen::Index f = 0; f < layer.surface.triangles.rows(); ++f) {
      const auto triangle = layer.surface.triangles.row(f);
      const double third = triangle_normal_2a(layer.surface.vertices, triangle).norm() / 6;
      for (int i = 0; i < 3; ++i)
        values[first + static_cast<std::size_t>(triangle(i))].weight += third;
    }
  }
  return values;
}

void layer_metrics(const LayerStack& stack, double d_min, double d_max, Metrics& metrics,
                   Context& ctx) {
  metrics.layers = stack.isosurfaces;
  metrics.components = static_cast<int>(stack.layers.size());
  const ThicknessReport report = measure_thickness(stack, d_min, d_max, ctx);
  if (!(report.area > 0)) return;
  metrics.thickness_mm = {report.min, report.p1, report.p50, report.p99, report.max};
  metrics.thickness_outside_area_percent = report.outside_percent();
}

}  // namespace s3
