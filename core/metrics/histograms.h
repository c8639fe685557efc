// The histograms of a run (Figs. 1, 7, 10–13): curved and planar layers in one plot.
#pragma once
#include <string>
#include <vector>

#include "metrics/lpd_metrics.h"

namespace s3 {

struct SvgFile {
  std::string name;  // "support_free.svg", …
  std::string text;
};

/// What the plots show of one set of layers.
struct PlotData {
  LpdAngles angles;
  std::vector<WeightedValue> thickness;  // mm, weighted by layer area
  std::vector<WeightedValue> strain;     // weighted by volume; empty without a load case
};

/// support_free.svg, surface_quality.svg, strength.svg (with critical tets), thickness.svg,
/// strain.svg and residual.svg (Π after each outer iteration); a plot without data is left out.
/// @param residual_history  rad
/// @param d_min, d_max      mm: the range of the layers' thickness
std::vector<SvgFile> histograms(const PlotData& curved, const PlotData& planar,
                                const std::vector<double>& residual_history, double d_min,
                                double d_max);

}  // namespace s3
