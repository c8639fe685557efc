// How well the lines of hybrid layers follow the stress and keep their distance: measured on the
// layer's surface, knowing nothing of how the lines were made.
//
// Samples lie on a regular subdivision of every triangle, a bead apart; those nearer to an
// infill path than to any other count. The *deviation* is the angle between the path at the nearest
// point and τ_max projected on the triangle, where that lies in S. The *spacing* is the distance
// between the two strands that the sample lies between, across the nearest one, where they run side
// by side, at most 45° apart; a wall is a strand too. What a bead covers within its turn at a wall,
// or at its end where it runs into one, lies between no strands and has no spacing: the distance
// across to a wall ahead says how near the end is, whatever the spacing. A place there that the
// bead does not cover counts as a gap.
#pragma once
#include <vector>

#include "base/context.h"
#include "toolpaths/boundary_distance.h"
#include "toolpaths/layer_stress.h"
#include "toolpaths/toolpaths.h"

namespace s3 {

/// @param width  the nominal bead width w, mm
LineQuality measure_lines(const LayerMesh& layer, const LayerStress& stress,
                          const std::vector<Path>& paths, double width, const Context& ctx);

}  // namespace s3
