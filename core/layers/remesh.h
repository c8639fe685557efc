// Isotropic remeshing of a layer: marching tets leave slivers, toolpaths need even triangles
// (Sec. 4.2).
#pragma once
#include "base/context.h"
#include "layers/isosurface.h"

namespace s3 {

struct RemeshTarget {
  double edge_length = 1;            // mm
  double boundary_tolerance = 0.02;  // mm: how far the boundary curve may leave the original one
};

/// Splits, collapses and flips edges and relaxes vertices along the surface until edges are about
/// the target length.
///
/// Interior vertices stay on `raw` (closest point), boundary vertices on its boundary curve within
/// the tolerance; the result is manifold (vertices where two sheets touch are doubled), oriented as
/// `raw`, and no triangle folds over. Normals are interpolated from `raw`, source tets are those of
/// the nearest raw triangle.
Isosurface remesh(const Isosurface& raw, const RemeshTarget& target, Context& ctx);

}  // namespace s3
