#include "metrics/svg_plot.h"

#include <algorithm>
#include <cmath>

#include "metrics/svg_text.h"

namespace s3 {
namespace {

constexpr double kWidth = 720, kHeight = 400;
constexpr double kLeft = 70, kRight = 700, kTop = 62, kBottom = 342;
constexpr const char* kColors[] = {"#1f6fb4", "#e58a2c"};  // told apart by the colour-blind too
constexpr const char* kFeasibleColor = "#dff0de";

/// The largest of 1, 2, 5 × 10^k that gives at least about `wanted` steps.
double tick_step(double range, double wanted) {
  const double raw = range / wanted;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= raw) return factor * power;
  return power;
}

/// A frame with axes, into which marks are drawn by their data coordinates.
class Plot {
 public:
  Plot(double x_min, double x_max, double y_max) : x_min_(x_min), x_max_(x_max), y_max_(y_max) {
    svg_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + svg_number(kWidth) + " " +
           svg_number(kHeight) + "\" width=\"" + svg_number(kWidth) + "\" height=\"" +
           svg_number(kHeight) +
           "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#222\">\n";
    rect(0, 0, kWidth, kHeight, "#ffffff");
  }

  double x(double value) const {
    return kLeft + (value - x_min_) / (x_max_ - x_min_) * (kRight - kLeft);
  }
  double y(double value) const { return kBottom - value / y_max_ * (kBottom - kTop); }

  void rect(double left, double top, double width, double height, const char* color) {
    svg_ += "<rect x=\"" + svg_number(left) + "\" y=\"" + svg_number(top) + "\" width=\"" +
            svg_number(width) + "\" height=\"" + svg_number(height) + "\" fill=\"" + color +
            "\"/>\n";
  }
  void line(double x1, double y1, double x2, double y2, const char* color) {
    svg_ += "<line x1=\"" + svg_number(x1) + "\" y1=\"" + svg_number(y1) + "\" x2=\"" +
            svg_number(x2) + "\" y2=\"" + svg_number(y2) + "\" stroke=\"" + color + "\"/>\n";
  }
  void label(double at_x, double at_y, const std::string& text, const char* anchor,
             const char* more = "") {
    svg_ += "<text x=\"" + svg_number(at_x) + "\" y=\"" + svg_number(at_y) + "\" text-anchor=\"" +
            anchor + "\"" + more + ">" + svg_escaped(text) + "</text>\n";
  }
  void circle(double at_x, double at_y, const char* color) {
    svg_ += "<circle cx=\"" + svg_number(at_x) + "\" cy=\"" + svg_number(at_y) +
            "\" r=\"3\" fill=\"" + color + "\"/>\n";
  }

  void titles(const std::string& title, const std::string& x_label, const std::string& y_label) {
    label(kLeft, 24, title, "start", " font-size=\"16\" font-weight=\"bold\"");
    label((kLeft + kRight) / 2, kHeight - 14, x_label, "middle");
    const std::string turned =
        " transform=\"rotate(-90 20 " + svg_number((kTop + kBottom) / 2) + ")\"";
    label(20, (kTop + kBottom) / 2, y_label, "middle", turned.c_str());
  }

  /// One entry of the legend, below the title.
  void legend(const char* color, const std::string& name) {
    rect(legend_x_, 38, 14, 11, color);
    label(legend_x_ + 19, 48, name, "start");
    constexpr double kLetter = 6.4;  // about the mean width of a letter
    legend_x_ += 43 + kLetter * static_cast<double>(name.size());
  }

  void grid(double x_step, double y_step) {
    constexpr double kRounding = 1e-9;
    for (double v = 0; v <= y_max_ * (1 + kRounding); v += y_step) {
      line(kLeft, y(v), kRight, y(v), "#e4e4e4");
      label(kLeft - 8, y(v) + 4, svg_number(v), "end");
    }
    for (double v = std::ceil(x_min_ / x_step - kRounding) * x_step;
         v <= x_max_ + kRounding * x_step; v += x_step) {
      line(x(v), kBottom, x(v), kBottom + 5, "#444444");
      label(x(v), kBottom + 19, svg_number(v), "middle");
    }
    line(kLeft, kBottom, kRight, kBottom, "#444444");
  }

  std::string finish() && { return std::move(svg_) + "</svg>\n"; }
  std::string& svg() { return svg_; }

 private:
  double x_min_, x_max_, y_max_;
  double legend_x_ = kLeft;
  std::string svg_;
};

std::vector<double> bin_percents(const HistogramPlot& plot, const HistogramSeries& series) {
  std::vector<double> bins(static_cast<std::size_t>(plot.bins), 0.0);
  double total = 0;
  for (const WeightedValue& v : series.values) {
    const double at = (v.value - plot.x_min) / (plot.x_max - plot.x_min) * plot.bins;
    bins[static_cast<std::size_t>(std::clamp(at, 0.0, plot.bins - 1.0))] += v.weight;
    total += v.weight;
  }
  if (total > 0)
    for (double& bin : bins) bin *= 100 / total;
  return bins;
}

/// The next round number above the highest bar, with its grid step.
std::pair<double, double> y_axis(double highest) {
  const double step = tick_step(std::max(highest, 1e-9), 4);
  return {std::ceil(highest / step) * step, step};
}

}  // namespace

std::string histogram_svg(const HistogramPlot& plot) {
  std::vector<std::vector<double>> bins;
  double highest = 0;
  for (const HistogramSeries& series : plot.series) {
    bins.push_back(bin_percents(plot, series));
    highest = std::max(highest, *std::max_element(bins.back().begin(), bins.back().end()));
  }
  const auto [y_max, y_step] = y_axis(highest > 0 ? highest : 1);
  Plot out(plot.x_min, plot.x_max, y_max);
  for (const auto& [from, to] : plot.feasible)
    out.rect(out.x(from), kTop, out.x(to) - out.x(from), kBottom - kTop, kFeasibleColor);
  out.grid(tick_step(plot.x_max - plot.x_min, 9), y_step);
  out.titles(plot.title, plot.x_label, plot.y_label);
  const double bin_width = (kRight - kLeft) / plot.bins;
  const double bar_width =
      0.9 * bin_width / static_cast<double>(std::max<std::size_t>(1, bins.size()));
  for (std::size_t s = 0; s < bins.size(); ++s) {
    out.legend(kColors[s % 2], plot.series[s].name);
    for (std::size_t b = 0; b < bins[s].size(); ++b) {
      if (bins[s][b] <= 0) continue;
      const double left =
          kLeft + bin_width * (static_cast<double>(b) + 0.05) + bar_width * static_cast<double>(s);
      out.rect(left, out.y(bins[s][b]), bar_width, kBottom - out.y(bins[s][b]), kColors[s % 2]);
    }
  }
  if (!plot.feasible.empty()) out.legend(kFeasibleColor, plot.feasible_label);
  return std::move(out).finish();
}

std::string curve_svg(const std::string& title, const std::string& x_label,
                      const std::string& y_label, const std::vector<double>& values) {
  const double highest = values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  const auto [y_max, y_step] = y_axis(highest > 0 ? highest : 1);
  const auto count = static_cast<double>(std::max<std::size_t>(2, values.size()));
  Plot out(1, count, y_max);
  out.grid(std::max(1.0, tick_step(count - 1, 9)), y_step);
  out.titles(title, x_label, y_label);
  out.svg() += std::string("<polyline fill=\"none\" stroke=\"") + kColors[0] +
               "\" stroke-width=\"2\" points=\"";
  for (std::size_t i = 0; i < values.size(); ++i)
    out.svg() +=
        svg_number(out.x(1 + static_cast<double>(i))) + "," + svg_number(out.y(values[i])) + " ";
  out.svg() += "\"/>\n";
  for (std::size_t i = 0; i < values.size(); ++i)
    out.circle(out.x(1 + static_cast<double>(i)), out.y(values[i]), kColors[0]);
  return std::move(out).finish();
}

}  // namespace s3
