// Keeps ∇G within the cone that the machine reaches: in every tet, whatever came before.
#pragma once
#include "base/context.h"
#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "scalar_field/field_operators.h"

namespace s3 {

/// Tets whose ∇G is more than `max_tilt` (rad, below π/2) away from z, or zero.
Index count_tilted(const TetMesh& rest, const FieldOperators& operators, const Values& value,
                   double max_tilt);

/// Changes `value` as little as it can so that ∇G is within `max_tilt` of z in every tet. A local
/// repair comes first; what it leaves is blended with planar layers, just enough: the cone is
/// convex and planar layers are inside it, so this always ends with none. (x, y, G) is then free of
/// foldovers, since ∂G/∂z > 0.
Values limit_tilt(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                  Values value, double max_tilt, Context& ctx);

}  // namespace s3
