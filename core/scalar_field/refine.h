// The constrained solve for G itself: the heart of `deform.method refined` (it goes beyond the
// paper's Sec. 4.1).
#pragma once
#include "base/context.h"
#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"
#include "scalar_field/field_operators.h"

namespace s3 {

struct RefineParams {
  double max_tilt = 1.5;         // rad, below π/2: ∇G stays within this angle of z
  double thickness_ratio = 2.5;  // r: ‖∇G‖ stays within [1/√r, √r] of its usual size
};

/// Refines the field `start` by the alternating direction method of multipliers with one constant
/// matrix.
///
/// Hard constraints (with dual variables): H_SF of every tet with a margin, the machine's cone, the
/// range of ‖∇G‖, the concave angle of the layers, and support for every island that appears. Soft
/// objectives: H_SQ, H_SR. Lengths do not occur in it: a model ten times as large has ten times the
/// field.
/// @param start  #V, mm; anchors hold their value
/// @return #V, mm: the best iterate
Values refine_field(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                    const ObjectiveField& objectives, const ObjectiveParams& objective_params,
                    const Values& start, const RefineParams& params, Context& ctx);

}  // namespace s3
