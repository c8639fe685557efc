#include "base/stage.h"

#include <array>

namespace s3 {

std::string_view stage_name(Stage stage) {
  constexpr std::array<std::string_view, 14> kNames = {
      "mesh",        "tetrahedralize", "fea",        "objectives", "quaternion_field",
      "deformation", "scalar_field",   "outer_loop", "layers",     "toolpaths",
      "waypoints",   "motion",         "export",     "metrics"};
  return kNames.at(static_cast<std::size_t>(stage));
}

}  // namespace s3
