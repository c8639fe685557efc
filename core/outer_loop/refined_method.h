// The method `refined`: a short start by Sec. 3, then a constrained solve for the field itself.
#pragma once
#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"
#include "outer_loop/deformer.h"

namespace s3 {

/// As deform() with `deform.method` = refined. The deformed shape is (x, y, G): free of foldovers,
/// since ∂G/∂z > 0 in every tet on exit. The rotation of a tet is the smallest one that turns its
/// print direction upright.
DeformResult refined_method(const TetMesh& rest, const ObjectiveField& objectives,
                            const ObjectiveParams& objective_params, const DeformParams& params,
                            double thickness_ratio, Context& ctx);

}  // namespace s3
