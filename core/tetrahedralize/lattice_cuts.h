// Where the border of a solid crosses the edges of a lattice.
#pragma once
#include <vector>

#include "base/context.h"
#include "mesh/aabb_tree.h"
#include "mesh/winding_number.h"
#include "tetrahedralize/bcc_lattice.h"

namespace s3 {

/// The solid of a surface: inside is winding number over 1/2.
struct SurfaceSolid {
  explicit SurfaceSolid(const TriMesh& mesh)
      : winding(mesh),
        tree(mesh),
        normals(triangle_normals(mesh)),
        box(bounding_box(mesh.vertices)) {}
  Vec3 normal(const Closest& closest) const { return normals.row(closest.triangle); }

  WindingNumber winding;
  AabbTree tree;
  Directions normals;  // #F×3
  Box box;
};

/// A lattice edge from a vertex inside to one outside, and where it leaves the solid.
struct LatticeCut {
  Index inner, outer;
  double t;    // from inner (0) to outer (1)
  Vec3 point;  // mm
};

/// The winding number at each lattice vertex, rounded and clamped to ±100; positive is inside.
std::vector<signed char> winding_at_vertices(const BccLattice& lattice, const SurfaceSolid& solid,
                                             Context& ctx);

/// One cut for each edge between inside and outside, ordered by the owner of the edge
/// (BccLattice::own_edges). Where the edge crosses the surface itself once, the cut lies on it;
/// where it passes a hole, on the sheet of winding number 1/2.
/// @param winding  by winding_at_vertices()
std::vector<LatticeCut> lattice_cuts(const BccLattice& lattice,
                                     const std::vector<signed char>& winding,
                                     const SurfaceSolid& solid, Context& ctx);

}  // namespace s3
