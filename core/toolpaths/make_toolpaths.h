// From layers to toolpaths (Sec. 5.1): contour-parallel, and on layers through the critical region
// S walls around lines along the largest stress.
#pragma once
#include <string>

#include "base/context.h"
#include "fea/stress.h"
#include "layers/layer.h"
#include "params/param_info.h"
#include "toolpaths/toolpaths.h"

namespace s3 {

struct ToolpathParams {
  double width = 0;                 // mm, bead width; 0: the nozzle's diameter
  double spacing = 1.0;             // mm between waypoints
  std::string strategy = "hybrid";  // or "contour"
  int walls = 2;                    // contours around the lines of a hybrid layer
};

template <class Visitor>
void describe(Visitor& v, ToolpathParams& p) {
  v(p.width,
    ParamInfo{
        .key = "toolpath.width",
        .label = "Bead width",
        .unit = "mm",
        .doc = "Width of a bead and distance between contours; 0 takes the nozzle's diameter.",
        .min = 0,
        .max = 1000,
        .stage = Stage::toolpaths});
  v(p.spacing, ParamInfo{.key = "toolpath.spacing",
                         .label = "Waypoint distance",
                         .unit = "mm",
                         .doc = "Largest distance between two waypoints along a path.",
                         .min = 1e-3,
                         .max = 1000,
                         .stage = Stage::waypoints});
  v(p.strategy,
    ParamInfo{.key = "toolpath.strategy",
              .label = "Toolpath strategy",
              .unit = "",
              .doc = "contour: contours everywhere; hybrid: on layers through the critical region, "
                     "contours around lines along the largest stress, where the strength "
                     "objective is on.",
              .choices = {"hybrid", "contour"},
              .stage = Stage::toolpaths});
  v(p.walls, ParamInfo{.key = "toolpath.walls",
                       .label = "Walls",
                       .unit = "",
                       .doc = "Contours around the lines of a hybrid layer.",
                       .min = 1,
                       .max = 100,
                       .stage = Stage::toolpaths});
}

/// Contour-parallel paths of one layer component, measured and ordered.
/// @param width  w, mm > 0
LayerPaths contour_parallel(const Layer& layer, double width, const Context& ctx);

/// Walls around lines along τ_max (hybrid.h), measured and ordered; contour-parallel where the
/// layer does not pass through S.
/// @param width  w, mm > 0
/// @param walls  ≥ 1
LayerPaths hybrid_parallel(const Layer& layer, const StressField& stress, double width, int walls,
                           const Context& ctx);

/// Whether paths come with what is measured on them: areas, coverage, lines. That takes about a
/// third of the time.
enum class PathFigures { measured, left_out };

/// Paths of every component, walls from outside to inside, each closed path starting near the end
/// of the one before and the outermost near the start of the layer below (one seam).
/// Warns "toolpaths.thin_area" where more than 0.2 % of the area is too thin for a bead, or has no
/// boundary to start from; that is measured, too.
/// @param stress  on the tets that the layers were cut from; null: every layer is contour-parallel
/// @throws Error "toolpaths.bad_width" unless the width is positive and finite
Toolpaths make_toolpaths(const LayerStack& stack, const StressField* stress,
                         const ToolpathParams& params, double nozzle_diameter, Context& ctx,
                         PathFigures figures = PathFigures::measured);

}  // namespace s3
