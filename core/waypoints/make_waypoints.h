// From toolpaths to waypoints (Sec. 5.1): resampling, extrusion, speed, and travels that clear what
// is printed.
//
// * Resampling: corners first (the path stays within `chord_tolerance` of its waypoints' polyline),
// then equal steps of
//   at most `spacing` between them. Closed paths end where they start.
// * Extrusion: a bead's cross-section is the rectangle width × height. Contours tile a layer with
// beads of exactly their
//   width, so the volume of all beads is that of the layer, area × thickness; the rounding of the
//   sides of one bead is what its neighbours fill.
// * Speed: constant at the tip, lowered where width × height × speed would exceed the hot end's
// flow.
// * Travels leave along the normal, pass over at a height where nothing printed is nearer than
// `clearance`, and arrive
//   along the normal. The first waypoint is an approach from above, the last a retreat.
#pragma once
#include "base/context.h"
#include "layers/layer.h"
#include "toolpaths/toolpaths.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// What waypoints depend on, from job and machine (motion/machine_profile.h: waypoint_settings).
struct WaypointSettings {
  double spacing = 1.0;           // mm
  double chord_tolerance = 0.05;  // mm
  double clearance =
      1.0;  // mm between the tip and anything printed on travels; about a bead's width
  double filament_diameter = 1.75;  // mm
  double print_speed = 15;          // mm/s
  double travel_speed = 50;         // mm/s
  double max_flow = 10;             // mm³/s
};

/// Waypoints of all paths in order. Travel waypoints between paths have width and height 0, the one
/// that arrives at a path has the path's. Warns "waypoints.travel_blocked" where no way was found
/// that clears the print.
/// @throws Error "waypoints.bad_settings" when a setting is not positive
Waypoints make_waypoints(const LayerStack& stack, const Toolpaths& toolpaths,
                         const WaypointSettings& settings, Context& ctx);

}  // namespace s3
