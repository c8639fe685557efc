// The hybrid strategy of Sec. 5.1 (Fang et al. 2020): contours along the boundary, and inside of
// them lines along the largest stress.
#pragma once
#include "base/context.h"
#include "toolpaths/contour_parallel.h"
#include "toolpaths/layer_stress.h"

namespace s3 {

/// Replaces the contours inside of the outermost `walls` by evenly spaced lines along the stress:
/// stripes of one spacing, moved across where walls and ends of lines leave it uneven.
/// Where a layer is too narrow for lines between the walls, its contours stay.
/// @param width  w, mm
/// @param walls  ≥ 1
void fill_with_lines(const LayerStress& stress, double width, int walls, ContourPlan& plan,
                     const Context& ctx);

}  // namespace s3
