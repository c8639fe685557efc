// Plots as SVG text: histograms of two series with their feasible range, and a curve.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace s3 {

struct WeightedValue {
  double value = 0;
  double weight = 0;
};

struct HistogramSeries {
  std::string name;
  std::vector<WeightedValue> values;
};

struct HistogramPlot {
  std::string title, x_label, y_label;
  double x_min = 0, x_max = 1;
  int bins = 36;
  std::string feasible_label;                       // what the shaded ranges mean
  std::vector<std::pair<double, double>> feasible;  // shaded ranges of x
  std::vector<HistogramSeries> series;              // at most two, drawn as bars side by side
};

/// Bars in percent of each series' own weight. Values outside [x_min, x_max] count in the first and
/// last bin.
std::string histogram_svg(const HistogramPlot& plot);

/// Values over 1, 2, 3, …; the y axis starts at 0.
std::string curve_svg(const std::string& title, const std::string& x_label,
                      const std::string& y_label, const std::vector<double>& values);

}  // namespace s3
