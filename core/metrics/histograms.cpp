#include "metrics/histograms.h"

#include <algorithm>

#include "base/units.h"

namespace s3 {
namespace {

HistogramPlot angle_plot(const char* title, const char* x_label, const char* y_label, double x_max,
                         int bins) {
  HistogramPlot plot;
  plot.title = title;
  plot.x_label = x_label;
  plot.y_label = y_label;
  plot.x_max = x_max;
  plot.bins = bins;
  return plot;
}

HistogramPlot support_free_plot() {
  auto plot =
      angle_plot("Support free", "angle between surface normal and print direction (degrees)",
                 "share of the surface (%)", 180, 36);
  plot.feasible = {{0, 135}};
  plot.feasible_label = "prints without support";
  return plot;
}

HistogramPlot surface_quality_plot() {
  auto plot = angle_plot("Surface quality",
                         "angle between surface normal and print direction, either way (degrees)",
                         "share of the surface (%)", 90, 36);
  plot.feasible = {{0, 10}, {80, 90}};
  plot.feasible_label = "no stair-steps";
  return plot;
}

HistogramPlot strength_plot() {
  auto plot = angle_plot("Strength", "angle between largest tension and layer (degrees)",
                         "share of the critical tets (%)", 90, 36);
  plot.feasible = {{0, 10}};
  plot.feasible_label = "the layer carries the tension";
  return plot;
}

HistogramPlot thickness_plot(double d_min, double d_max) {
  auto plot = angle_plot("Layer thickness", "distance to the material below (mm)",
                         "share of the layers' area (%)", 1.25 * d_max, 40);
  plot.feasible = {{d_min, d_max}};
  plot.feasible_label = "allowed range";
  return plot;
}

/// Up to the largest strain of both: the last bars are what the maximum speaks of.
HistogramPlot strain_plot(const PlotData& curved, const PlotData& planar) {
  double largest = 0;
  for (const PlotData* data : {&curved, &planar})
    for (const WeightedValue& strain : data->strain) largest = std::max(largest, strain.value);
  return angle_plot("Strain of the print under its loads", "largest principal strain",
                    "share of the volume (%)", largest > 0 ? largest : 1, 40);
}

}  // namespace

std::vector<SvgFile> histograms(const PlotData& curved, const PlotData& planar,
                                const std::vector<double>& residual_history, double d_min,
                                double d_max) {
  std::vector<SvgFile> files;
  const auto add = [&](const char* name, HistogramPlot plot,
                       const std::vector<WeightedValue>& of_curved,
                       const std::vector<WeightedValue>& of_planar) {
    if (!of_curved.empty()) plot.series.push_back({"curved layers", of_curved});
    if (!of_planar.empty()) plot.series.push_back({"planar layers", of_planar});
    if (!plot.series.empty()) files.push_back({name, histogram_svg(plot)});
  };
  add("support_free.svg", support_free_plot(), curved.angles.support_free,
      planar.angles.support_free);
  add("surface_quality.svg", surface_quality_plot(), curved.angles.surface_quality,
      planar.angles.surface_quality);
  add("strength.svg", strength_plot(), curved.angles.strength, planar.angles.strength);
  add("thickness.svg", thickness_plot(d_min, d_max), curved.thickness, planar.thickness);
  add("strain.svg", strain_plot(curved, planar), curved.strain, planar.strain);
  if (!residual_history.empty()) {
    std::vector<double> in_degrees;
    in_degrees.reserve(residual_history.size());
    for (const double residual : residual_history) in_degrees.push_back(degrees(residual));
    files.push_back(
        {"residual.svg", curve_svg("Mean distance to the feasible directions (Eq. 13)",
                                   "outer iteration", "residual (degrees)", in_degrees)});
  }
  return files;
}

}  // namespace s3
