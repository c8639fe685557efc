// Coverage measured from what is printed alone: layers and waypoints, as files hold them.
#pragma once
#include <optional>

#include "base/context.h"
#include "layers/layer.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// Share of the layers' area that lies within half a bead width of a bead of the same isosurface,
/// in percent; empty without layers. Independent of how toolpaths count their own coverage:
/// straight beads between waypoints, and samples spread evenly over the triangles, about four
/// across a bead.
/// @param bead_width  mm: sets the distance of the samples
std::optional<double> printed_coverage_percent(const LayerStack& stack, const Waypoints& waypoints,
                                               double bead_width, Context& ctx);

}  // namespace s3
