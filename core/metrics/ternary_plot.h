// Figures over triples of weights, as triangles of coloured hexagons (Fig. 19).
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/types.h"

namespace s3 {

/// One triangle of the plot.
struct TernaryFigure {
  std::string title;
  std::vector<std::optional<double>> values;  // one a triple; empty where there is none
  std::optional<double> planar;               // the same of planar layers, for the caption
  bool less_is_better = false;
  int digits = 1;  // behind the point
};

struct TernaryPlot {
  std::string title;
  std::array<std::string, 3> corners;  // top, lower right, lower left
  std::vector<Vec3> weights;           // share of each corner, ≥ 0, on any scale but not all 0
  std::vector<TernaryFigure> figures;
};

/// Every triple is a hexagon at its place in the triangle, with its value and a colour between the
/// worst and the best value of its figure. Hexagons of a grid touch; nothing is interpolated.
std::string ternary_svg(const TernaryPlot& plot);

}  // namespace s3
