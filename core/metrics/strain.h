// The strain of the printed part under its load cases (Sec. 5.2.3): an analysis with the material's
// constants along and across the beads.
#pragma once
#include <vector>

#include "base/context.h"
#include "fea/load_case.h"
#include "mesh/tet_mesh.h"
#include "metrics/metrics.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// The frame of every tet: column 1 the tangent of the bead nearest to its centroid, column 3 that
/// bead's layer normal (without its share along the tangent), column 2 completes them.
/// @throws Error "metrics.no_beads" without a single extruded segment
std::vector<Mat3> bead_frames(const TetMesh& rest, const Waypoints& waypoints, Context& ctx);

/// The largest principal strain of every tet, the worst over the load cases. The paper leaves the
/// scalar open; this is the one that goes with its maximum principal stress.
/// @param frames  as of bead_frames()
Values printed_strain(const TetMesh& rest, const std::vector<Mat3>& frames, const LoadCases& file,
                      Context& ctx);

/// The same for the beads of a print.
Values printed_strain(const TetMesh& rest, const Waypoints& waypoints, const LoadCases& file,
                      Context& ctx);

/// Maximum, 99.9th percentile and mean of printed_strain(), weighted by volume. Only differences
/// between prints of one mesh mean something: beads are as strong as solid material here.
/// @param volume  #T
StrainFigures strain_figures(const Values& strain, const Values& volume);

}  // namespace s3
