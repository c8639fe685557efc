// The field whose gradient fits given print directions best: the short start of `deform.method
// refined`.
#pragma once
#include "base/context.h"
#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "scalar_field/field_operators.h"

namespace s3 {

/// G that minimises Σ_t volume(t) ‖∇G_t − direction(t)‖², with the anchors at their height.
/// @param direction  #T×3, R(q)⁻¹ d_p of every tet
/// @param tolerance  of the linear solve
/// @return #V, mm
Values fit_field(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                 const Directions& direction, double tolerance, Context& ctx);

}  // namespace s3
