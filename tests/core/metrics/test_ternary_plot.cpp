#include "metrics/ternary_plot.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <doctest/doctest.h>

namespace {

// The centre of every hexagon, in the order of the file: the mean of its corners.
std::vector<Eigen::Vector2d> hexagon_centers(const std::string& svg) {
  std::vector<Eigen::Vector2d> centers;
  const std::string start = "<polygon points=\"";
  for (std::size_t at = svg.find(start); at != std::string::npos; at = svg.find(start, at + 1)) {
    const char* text = svg.c_str() + at + start.size();
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int corners = 0;
    while (*text != '"') {
      char* end = nullptr;
      const double x = std::strtod(text, &end);
      const double y = std::strtod(end + 1, &end);
      sum += Eigen::Vector2d(x, y);
      ++corners;
      text = end + 1;
    }
    if (corners == 6) centers.push_back(sum / 6);
  }
  return centers;
}

s3::TernaryPlot plot_of(std::vector<s3::Vec3> weights, std::vector<std::optional<double>> values) {
  s3::TernaryPlot plot;
  plot.corners = {"up", "right", "left"};
  plot.weights = std::move(weights);
  plot.figures = {{"figure", std::move(values), {}, false, 1}};
  return plot;
}

}  // namespace

TEST_CASE("hexagons stand at the weighted mean of the corners, whatever the weights' scale") {
  const std::string svg = s3::ternary_svg(
      plot_of({{1, 0, 0}, {0, 1, 0}, {0, 0, 0.25}, {0.5, 0.25, 0.25}, {1, 1, 0}}, {1, 2, 3, 4, 5}));
  const auto at = hexagon_centers(svg);
  REQUIRE(at.size() == 5);
  CHECK((at[0] - at[1]).norm() == doctest::Approx((at[1] - at[2]).norm()).epsilon(1e-4));
  CHECK(at[0].y() < at[1].y());
  CHECK(at[2].x() < at[1].x());
  CHECK((0.5 * at[0] + 0.25 * at[1] + 0.25 * at[2] - at[3]).norm() < 0.01);
  CHECK((0.5 * at[0] + 0.5 * at[1] - at[4]).norm() < 0.01);
}

TEST_CASE("the best value is yellow, the worst dark, a missing one grey") {
  auto plot = plot_of({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {10, std::nullopt, 30});
  const auto fill = [](const std::string& svg, int hexagon) {
    std::size_t at = 0;
    for (int i = 0; i <= hexagon; ++i) at = svg.find("<polygon", at + 1);
    return svg.substr(svg.find("fill=\"", at) + 6, 7);
  };
  const std::string more = s3::ternary_svg(plot);
  CHECK(fill(more, 0) == "#440154");
  CHECK(fill(more, 1) == "#d9d9d9");
  CHECK(fill(more, 2) == "#fde725");
  plot.figures[0].less_is_better = true;
  const std::string less = s3::ternary_svg(plot);
  CHECK(fill(less, 0) == "#fde725");
  CHECK(fill(less, 2) == "#440154");
  // The legend names both ends and the middle.
  for (const char* value : {">10.0<", ">20.0<", ">30.0<"})
    CHECK(less.find(value) != std::string::npos);
}

TEST_CASE("a single value, none at all and no figure still make a picture") {
  CHECK(s3::ternary_svg(plot_of({{1, 0, 0}}, {7})).find(">7.0<") != std::string::npos);
  const std::string none = s3::ternary_svg(plot_of({{1, 0, 0}}, {std::nullopt}));
  CHECK(none.find("nan") == std::string::npos);
  CHECK(none.ends_with("</svg>\n"));
  CHECK(s3::ternary_svg({}).ends_with("</svg>\n"));
}
