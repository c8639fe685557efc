// What a print costs, and how closely it follows the model: length, coverage, material, time,
// surface error.
#pragma once
#include "base/context.h"
#include "layers/layer.h"
#include "mesh/tri_mesh.h"
#include "metrics/metrics.h"
#include "motion/machine_profile.h"
#include "toolpaths/toolpaths.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// Fills path_length_mm, coverage_percent (of the layers' area), overlap_percent (of the area wider
/// than two beads), and where there are lines along the stress stress_deviation_deg and
/// line_spacing.
void toolpath_metrics(const Toolpaths& toolpaths, Metrics& metrics);

/// Fills material_g and print_time_s: way over speed for prints and travels, without the machine's
/// accelerations.
void waypoint_metrics(const Waypoints& waypoints, const MachineProfile& machine, Metrics& metrics);

/// Fills surface_error_*: distances from samples of the model's surface to the surface of the
/// printed material (Sec. 5.2.1, Fig. 9), mm.
///
/// Each extruding segment becomes a tube around the bead's centre line (half a bead height below
/// the waypoints) with the area of the bead's cross-section. The error of a sample is |distance to
/// the nearest tube's axis − its radius|: exact outside the material, a lower bound inside. Samples
/// are the same for every set of waypoints of one surface.
/// @param surface  closed, mm, in the waypoints' frame; unused vertices are allowed
void surface_error(const TriMesh& surface, const Waypoints& waypoints, Metrics& metrics,
                   Context& ctx);

}  // namespace s3
