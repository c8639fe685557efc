#include "metrics/ternary_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "metrics/svg_text.h"

namespace s3 {
namespace {

using Place = Eigen::Vector2d;

constexpr double kPanelWidth = 350, kPanelHeight = 404, kHeader = 44;
constexpr double kSide = 232;             // of the triangle, px
constexpr double kLeft = 59, kTop = 100;  // of the triangle in its panel
constexpr double kBarTop = 362, kBarHeight = 12;
// Hexagons of few or close triples: neither larger than a quarter of the side nor out of sight.
constexpr double kLargest = 0.25, kSmallest = 0.03;
constexpr double kLeastForText = 30;  // px between hexagons
constexpr int kBarSteps = 29;

struct Color {
  double red = 0, green = 0, blue = 0;
};

// From dark blue to yellow with steadily rising lightness (after viridis of matplotlib): ordered
// for the colour-blind too, and in print without colours.
constexpr std::array<Color, 7> kScale = {{{68, 1, 84},
                                          {67, 58, 130},
                                          {49, 104, 142},
                                          {33, 145, 140},
                                          {53, 183, 121},
                                          {144, 215, 67},
                                          {253, 231, 37}}};

constexpr Color kMissing = {217, 217, 217};

/// @param goodness  in [0, 1]
Color color_of(double goodness) {
  const double at = goodness * (kScale.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kScale.size() - 2);
  const double share = at - static_cast<double>(low);
  const Color &a = kScale[low], &b = kScale[low + 1];
  return {a.red + share * (b.red - a.red), a.green + share * (b.green - a.green),
          a.blue + share * (b.blue - a.blue)};
}

std::string hex(const Color& color) {
  char text[16];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", static_cast<unsigned>(std::lround(color.red)),
                static_cast<unsigned>(std::lround(color.green)),
                static_cast<unsigned>(std::lround(color.blue)));
  return text;
}

const char* readable_on(const Color& color) {
  const double lightness = 0.299 * color.red + 0.587 * color.green + 0.114 * color.blue;
  return lightness > 120 ? "#111111" : "#ffffff";
}

std::string fixed(double value, int digits) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

void add_text(std::string& svg, const Place& at, const std::string& text, const char* anchor,
              const std::string& more = "") {
  svg += "<text x=\"" + svg_number(at.x()) + "\" y=\"" + svg_number(at.y()) + "\" text-anchor=\"" +
         anchor + "\"" + more + ">" + svg_escaped(text) + "</text>\n";
}

/// Corners: top, lower right, lower left.
std::array<Place, 3> triangle(const Place& panel) {
  const double height = 0.5 * std::numbers::sqrt3 * kSide;
  return {panel + Place(kLeft + 0.5 * kSide, kTop), panel + Place(kLeft + kSide, kTop + height),
          panel + Place(kLeft, kTop + height)};
}

Place place_of(const Vec3& weights, const std::array<Place, 3>& corner) {
  return (weights.x() * corner[0] + weights.y() * corner[1] + weights.z() * corner[2]) /
         weights.sum();
}

/// Distance of hexagons in px: that of the two closest triples.
double hexagon_distance(const std::vector<Vec3>& weights) {
  const auto corner = triangle(Place::Zero());
  std::vector<Place> places;
  places.reserve(weights.size());
  for (const Vec3& w : weights) places.push_back(place_of(w, corner));
  double least = kLargest * kSide;
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double distance = (places[i] - places[j]).norm();
      if (distance > kSmallest * kSide) least = std::min(least, distance);
    }
  return least;
}

/// The range of a figure's values, and what lies where in it.
class Scale {
 public:
  explicit Scale(const TernaryFigure& figure) : less_is_better_(figure.less_is_better) {
    for (const std::optional<double>& value : figure.values) {
      if (!value) continue;
      low_ = any_ ? std::min(low_, *value) : *value;
      high_ = any_ ? std::max(high_, *value) : *value;
      any_ = true;
    }
  }
  bool any() const { return any_; }
  double at(double share) const { return low_ + share * (high_ - low_); }
  Color color(double value) const {
    if (!(high_ > low_)) return color_of(1);
    const double share = (value - low_) / (high_ - low_);
    return color_of(less_is_better_ ? 1 - share : share);
  }

 private:
  bool less_is_better_, any_ = false;
  double low_ = 0, high_ = 0;
};

void add_hexagon(std::string& svg, const Place& center, double distance, const std::string& fill) {
  svg += "<polygon points=\"";
  for (int k = 0; k < 6; ++k) {
    const double angle = (k + 0.5) * std::numbers::pi / 3;
    const Place p =
        center + distance / std::numbers::sqrt3 * Place(std::cos(angle), std::sin(angle));
    svg += svg_number(p.x()) + "," + svg_number(p.y()) + " ";
  }
  svg += "\" fill=\"" + fill + "\" stroke=\"#ffffff\" stroke-width=\"0.7\"/>\n";
}

/// The legend: colours with the values at both ends and in the middle.
void add_color_bar(std::string& svg, const Place& panel, const Scale& scale, int digits) {
  const double step = kSide / kBarSteps;
  for (int i = 0; i < kBarSteps; ++i) {
    const Place at = panel + Place(kLeft + i * step, kBarTop);
    svg += "<rect x=\"" + svg_number(at.x()) + "\" y=\"" + svg_number(at.y()) + "\" width=\"" +
           svg_number(step + 0.3) + "\" height=\"" + svg_number(kBarHeight) + "\" fill=\"" +
           hex(scale.color(scale.at(i / (kBarSteps - 1.0)))) + "\"/>\n";
  }
  for (const double share : {0.0, 0.5, 1.0})
    add_text(svg, panel + Place(kLeft + share * kSide, kBarTop + kBarHeight + 15),
             fixed(scale.at(share), digits), "middle", " font-size=\"11\"");
}

void add_panel(std::string& svg, const Place& panel, const TernaryPlot& plot,
               const TernaryFigure& figure) {
  const auto corner = triangle(panel);
  const double distance = hexagon_distance(plot.weights);
  const double beyond = distance / std::numbers::sqrt3;  // of a hexagon beyond the corner
  const Place middle = panel + Place(kLeft + 0.5 * kSide, 0);
  add_text(svg, middle + Place(0, 14), figure.title, "middle",
           " font-size=\"14\" font-weight=\"bold\"");
  if (figure.planar)
    add_text(svg, middle + Place(0, 31), "planar layers: " + fixed(*figure.planar, figure.digits),
             "middle", " font-size=\"11\" fill=\"#666666\"");
  add_text(svg, corner[0] - Place(0, beyond + 8), plot.corners[0], "middle");
  add_text(svg, corner[1] + Place(0, beyond + 16), plot.corners[1], "middle");
  add_text(svg, corner[2] + Place(0, beyond + 16), plot.corners[2], "middle");

  const Scale scale(figure);
  std::string labels;
  const double size = std::min(12.0, 0.21 * distance);
  for (std::size_t i = 0; i < plot.weights.size(); ++i) {
    const std::optional<double>& value = figure.values[i];
    const Place center = place_of(plot.weights[i], corner);
    const Color color = value ? scale.color(*value) : kMissing;
    add_hexagon(svg, center, distance, hex(color));
    if (distance < kLeastForText) continue;
    add_text(labels, center + Place(0, 0.36 * size), value ? fixed(*value, figure.digits) : "–",
             "middle",
             " font-size=\"" + svg_number(size) + "\" fill=\"" + readable_on(color) + "\"");
  }
  svg += "<polygon points=\"";
  for (const Place& c : corner) svg += svg_number(c.x()) + "," + svg_number(c.y()) + " ";
  svg += "\" fill=\"none\" stroke=\"#222222\" stroke-opacity=\"0.2\"/>\n" + labels;
  if (scale.any()) add_color_bar(svg, panel, scale, figure.digits);
}

}  // namespace

std::string ternary_svg(const TernaryPlot& plot) {
  const std::size_t columns =
      plot.figures.size() > 4 ? 3 : std::min<std::size_t>(2, plot.figures.size());
  const std::size_t rows = columns == 0 ? 0 : (plot.figures.size() + columns - 1) / columns;
  const double width = kPanelWidth * static_cast<double>(std::max<std::size_t>(1, columns));
  const double height = kHeader + kPanelHeight * static_cast<double>(rows);
  const std::string size = svg_number(width) + " " + svg_number(height);
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + size +
                    "\" width=\"" + svg_number(width) + "\" height=\"" + svg_number(height) +
                    "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" "
                    "fill=\"#222222\">\n<rect width=\"" +
                    svg_number(width) + "\" height=\"" + svg_number(height) +
                    "\" fill=\"#ffffff\"/>\n";
  add_text(svg, {0.5 * width, 28}, plot.title, "middle", " font-size=\"16\" font-weight=\"bold\"");
  for (std::size_t i = 0; i < plot.figures.size(); ++i) {
    const std::size_t row = i / columns, column = i % columns;
    add_panel(svg,
              {kPanelWidth * static_cast<double>(column),
               kHeader + kPanelHeight * static_cast<double>(row)},
              plot, plot.figures[i]);
  }
  return svg + "</svg>\n";
}

}  // namespace s3
