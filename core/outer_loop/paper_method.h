// The method `paper`: the loop of the paper's overview, steps (2) to (6), to its stop test
// (Sec. 4.1).
#pragma once
#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"
#include "outer_loop/deformer.h"

namespace s3 {

/// As deform() with `deform.method` = paper. G is the height of M^d.
///
/// Each outer iteration takes the rotations from M^d, optimises them (inner loop) and deforms M by
/// them. Ends when Π changes by less than 5 % and no pair gouges, at most after 20 iterations;
/// keeps the best iterate, one without gouging where there is one. Foldovers that are left are
/// repaired. Warnings: "outer_loop.gouging" when pairs still gouge, "outer_loop.tilt" where ∇G
/// leaves the cone of `max_tilt_deg`, which this method does not constrain.
DeformResult paper_method(const TetMesh& rest, const ObjectiveField& objectives,
                          const ObjectiveParams& objective_params, const DeformParams& params,
                          Context& ctx);

}  // namespace s3
