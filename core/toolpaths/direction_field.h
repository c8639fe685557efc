// A smooth field of line directions on a layer (Sec. 5.1): τ_max inside of S, a continuation of it
// elsewhere.
#pragma once
#include "base/context.h"
#include "toolpaths/layer_stress.h"
#include "toolpaths/stripe_mesh.h"

namespace s3 {

/// Directions up to sign that a field should have at some vertices.
struct LineGuides {
  Values trust;          // #V ≥ 0, as LayerStress::confidence
  Directions direction;  // #V×3 unit where the trust is positive
};

/// Directions up to sign at the vertices, unit and tangent to the layer.
///
/// Lines are complex numbers of twice their angle (Knöppel et al. 2013, "Globally optimal direction
/// fields"), fitted to the stress with its confidence as weight and a smoothness that reaches over
/// about two beads in S, and far where the stress says little.
/// @param start  #V×3 where the search begins; empty for the stress itself
/// @param width  w, mm
Directions direction_field(const StripeMesh& mesh, const LayerStress& stress,
                           const LineGuides& guides, const Directions& start, double width,
                           const Context& ctx);

/// The least rotation that takes the tangent plane of one normal to another's, applied to a vector.
Vec3 carry_tangent(const Vec3& tangent, const Vec3& from_normal, const Vec3& to_normal);

}  // namespace s3
