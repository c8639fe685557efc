#include "metrics/histograms.h"

#include <doctest/doctest.h>

namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE("a bar's height is its share of the weight") {
  s3::HistogramPlot plot;
  plot.x_max = 10;
  plot.bins = 10;
  plot.series = {{"one", {{0.5, 3}, {3.5, 1}, {-7, 1}, {99, 5}}}};
  const std::string svg = s3::histogram_svg(plot);
  // Shares 40 %, 10 % and 50 % over an axis of 50 %: heights of 224, 56 and 280 px; one more rect
  // is the legend's.
  CHECK(count(svg, "fill=\"#1f6fb4\"") == 4);
  CHECK(count(svg, "height=\"224\"") == 1);
  CHECK(count(svg, "height=\"56\"") == 1);
  CHECK(count(svg, "height=\"280\"") == 1);
  CHECK(svg.ends_with("</svg>\n"));
}

TEST_CASE("only what there is data for is plotted") {
  s3::PlotData curved, planar;
  curved.angles.support_free = {{90, 1}};
  planar.thickness = {{0.8, 1}};
  curved.strain = {{0.001, 2}, {0.004, 1}};
  planar.strain = {{0.002, 3}};
  const auto files = s3::histograms(curved, planar, {0.2, 0.1}, 0.4, 1);
  REQUIRE(files.size() == 4);
  CHECK(files[0].name == "support_free.svg");
  CHECK(files[0].text.find("planar") == std::string::npos);
  CHECK(files[1].name == "thickness.svg");
  CHECK(files[2].name == "strain.svg");
  CHECK(files[2].text.find("curved") < files[2].text.find("planar"));
  CHECK(files[3].name == "residual.svg");
  CHECK(count(files[3].text, "<circle") == 2);
}
