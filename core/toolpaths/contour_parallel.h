// Contour-parallel toolpaths (Sec. 5.1): iso-curves of the boundary distance, one bead apart, with
// the gap along the medial axis filled by beads of another width.
#pragma once
#include "base/context.h"
#include "layers/layer.h"
#include "params/param_info.h"
#include "toolpaths/toolpaths.h"

namespace s3 {

struct ToolpathParams {
  double width = 0;      // mm, bead width; 0: the nozzle's diameter
  double spacing = 1.0;  // mm between waypoints
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
}

/// Paths of one layer component, not yet ordered: closed walls at w/2, 3w/2, … and single beads
/// along the medial axis. Areas in the result are measured (coverage.h).
/// @param width  w, mm > 0
LayerPaths contour_parallel(const Layer& layer, double width, const Context& ctx);

/// Contour-parallel paths of every component, walls from outside to inside, each closed path
/// starting near the end of the one before and the outermost near the start of the layer below (one
/// seam).
/// Warns "toolpaths.thin_area" where more than 0.2 % of the area is too thin for a bead, or has no
/// boundary to start from.
/// @throws Error "toolpaths.bad_width" unless the width is positive and finite
Toolpaths make_toolpaths(const LayerStack& stack, const ToolpathParams& params,
                         double nozzle_diameter, Context& ctx);

}  // namespace s3
