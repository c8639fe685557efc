// Contour-parallel toolpaths (Sec. 5.1): iso-curves of the boundary distance, one bead apart, with
// the gap along the medial axis filled by beads of another width.
#pragma once
#include <vector>

#include "base/context.h"
#include "toolpaths/bead_rings.h"
#include "toolpaths/medial_axis.h"
#include "toolpaths/path_order.h"

namespace s3 {

constexpr double kSimplifyPath = 0.005;  // of w: how far a path may leave its exact place

/// The paths of one layer component, not yet ordered: closed walls at w/2, 3w/2, … and single beads
/// along the medial axis. Holes between them are not yet filled (hole_filler.h).
struct ContourPlan {
  WorkLayer work;
  BeadField field;
  MedialAxis axis;
  std::vector<PlannedPath> paths;  // none where the layer has no boundary
};

/// @param width  w, mm > 0
ContourPlan plan_contours(LayerMesh mesh, double width, const Context& ctx);

}  // namespace s3
