// How well paths fill a layer: measured on the layer's surface, knowing nothing of how the paths
// were made.
//
// Samples lie on a regular subdivision of every triangle. A sample is *covered* when a path passes
// within half its own width of it, on the same side of the layer (the normals agree). It is *laid
// twice* when two strands do so: a strand is a stretch of one path, and two stretches of a path are
// different strands when more than 1.5 widths of path lie between them, so the two legs of a corner
// count once. Overlap is counted where the layer is *wider than two beads*: inside of some
// disc of radius w or more that does not cross the boundary.
#pragma once
#include <vector>

#include "base/context.h"
#include "toolpaths/boundary_distance.h"
#include "toolpaths/toolpaths.h"

namespace s3 {

struct Coverage {
  double area = 0;     // mm² of the layer
  double covered = 0;  // mm²
  double wide = 0;     // mm² where the layer is wider than two beads
  double overlap = 0;  // mm² laid more than once in there; what is laid three times counts twice
  double thin = 0;     // mm² without a bead, because the layer is too narrow there
};

/// A disc on the layer that touches its boundary: vertices with their distance, and points of the
/// medial axis.
struct InnerDisc {
  Vec3 center;
  double radius;
};

/// @param distance  #V mm from the boundary
/// @param discs  dense enough that their union is the layer
/// @param least_width  mm: a place where no disc of this diameter fits into the layer is too narrow
/// for a bead
/// @param width  the nominal bead width w, mm
Coverage measure_coverage(const LayerMesh& layer, const Values& distance,
                          const std::vector<InnerDisc>& discs, const std::vector<Path>& paths,
                          double width, double least_width, const Context& ctx);

}  // namespace s3
