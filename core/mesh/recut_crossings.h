// A surface that crosses itself in a few places is cut open there and closed anew.
#pragma once
#include <optional>

#include "base/context.h"
#include "mesh/tri_mesh.h"
#include "mesh/validate.h"

namespace s3 {

struct Recut {
  TriMesh surface;
  MeshReport report;
  Defect removed;         // triangles cut out
  double area_share = 0;  // of the surface
};

/// Cuts out the triangles that cross each other and fills the holes; what crosses still, or anew,
/// is cut out with more and more of its neighbours. Only small cuts in bodies of their own: bodies
/// that cross each other overlap, and what is to become of them is no question of a few triangles.
/// @param report  of the surface, with all its intersecting pairs
/// @return nothing where that would take more than a twentieth of the area or change the volume by
///         more than a hundredth, or does not help
/// @throws Cancelled
std::optional<Recut> recut_crossings(const TriMesh& mesh, const MeshReport& report, Context& ctx);

}  // namespace s3
