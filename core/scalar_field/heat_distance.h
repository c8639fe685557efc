// Distance from the plate through the solid by the heat method: the first guess of the print
// directions for SR (Sec. 5.4.1).
#pragma once
#include "base/context.h"
#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "scalar_field/field_operators.h"

namespace s3 {

/// Heat is held at 1 on the anchors and spreads for a time; the field whose gradient fits the
/// direction in which it falls is the distance. The time is as short as rounding allows for the
/// heat to reach every tet: a path of any length is found, and corners are cut a little.
/// @return #V, mm: the anchors keep their height
Values heat_distance(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                     Context& ctx);

/// The normalised gradient of heat_distance(): away from the plate, along the solid.
/// @return #T×3 unit vectors
Directions heat_directions(const TetMesh& rest, const FieldOperators& operators,
                           const Anchors& anchors, Context& ctx);

}  // namespace s3
