// waypoints.csv: one line a waypoint, in print order.
//
// Lines that begin with '#' state units and frame; then comes a line with the names of the columns:
// layer,path,kind,x,y,z,nx,ny,nz,tx,ty,tz,width,height,e,speed,travel
// `layer` is the isosurface's number, `path` the running number of the path, `e` the mm of filament
// pushed on the way from the waypoint before, `travel` 1 where that way is made without extruding.
#pragma once
#include <string>
#include <string_view>

#include "waypoints/waypoints.h"

namespace s3 {

std::string write_waypoint_csv(const Waypoints& waypoints);

/// The inverse, for files from outside. The file does not name components: `component` is set to
/// `layer`.
/// @throws Error "export.bad_waypoint_csv" naming the line
Waypoints read_waypoint_csv(std::string_view text);

}  // namespace s3
