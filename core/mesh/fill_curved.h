// A curved cap for a hole: Liepa 2003, "Filling Holes in Meshes".
#pragma once
#include <array>
#include <vector>

#include "base/context.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// The surroundings of a hole.
struct HoleRim {
  std::vector<Index> loop;    // vertices, in the direction in which the fill's triangles see them
  std::vector<Vec3> outward;  // #loop: unit normal of the triangle behind loop[i] → loop[i+1]
  std::vector<std::array<Index, 2>> edges;  // sorted, (low, high): edges of the mesh that the fill
                                            // must not use again
  std::vector<std::vector<Index>> neighbours;  // #loop: vertices around loop[i]
};

struct CurvedFill {
  std::vector<Vec3> points;                     // new vertices, numbered from `first_new`
  std::vector<std::array<Index, 3>> triangles;  // empty when the hole could not be filled
};

/// Fills the hole with the triangulation of least bending, then least area; splits it to the size
/// of the edges around, and lets it continue the curvature of the surroundings.
/// @param points     of the mesh, mm
/// @param first_new  number of the first new vertex
/// @param fair       false: the triangulation alone, without new vertices
CurvedFill fill_curved(const Points& points, const HoleRim& rim, Index first_new, bool fair,
                       Context& ctx);

}  // namespace s3
