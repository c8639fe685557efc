// How high the beads of a layer are: what the solid between the layer and the material below needs.
#pragma once
#include "base/context.h"
#include "layers/layer_distance.h"
#include "mesh/aabb_tree.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// The height of the part under a layer that is not printed yet: the way along −n to the material,
/// the plate or out of the part, whichever comes first, within [d_min, d_max].
///
/// Not the layer's thickness, which is the distance to the nearest point and drops beside every rim
/// of a layer below: beads of that height would leave a groove along the rim. Under an overhang it
/// is less than the thickness, since the solid ends there.
/// @param part         the part's surface
/// @param normal       #V×3 unit, of the layer
/// @param d_min,d_max  mm
/// @return #V mm; the mean of the triangles around each vertex, so that the volume of
///         area × height is that of the triangles
Values bead_heights(const PrintedMaterial& material, const AabbTree& part, const TriMesh& layer,
                    const Directions& normal, double d_min, double d_max, Context& ctx);

}  // namespace s3
