// What a machine gets: resampled toolpaths with normal, bead, extrusion and speed (Sec. 5.1).
#pragma once
#include <vector>

#include "base/types.h"
#include "toolpaths/toolpaths.h"

namespace s3 {

/// Structure of arrays over #W waypoints in print order, rest frame: mm, z up, plate at z = 0.
struct Waypoints {
  Points position;       // #W×3 mm: the nozzle tip
  Directions normal;     // #W×3 unit: away from the material; the nozzle axis points against it
  Directions tangent;    // #W×3 unit: direction of travel
  Values width, height;  // #W mm: bead width; bead height = distance to the material below
  Values extrusion;  // #W mm of filament pushed on the way from the waypoint before; 0 on travels
  Values speed;      // #W mm/s: tip speed on the way to this waypoint
  std::vector<Index> component;  // #W: position in LayerStack::layers
  std::vector<Index> layer;      // #W: Layer::layer
  std::vector<Index> path;       // #W: running number of the path
  std::vector<PathKind> kind;    // #W
  std::vector<char> travel;      // #W: 1 if the way to this waypoint is made without extruding

  Index size() const { return static_cast<Index>(position.rows()); }
};

}  // namespace s3
