// Closes seams: vertices that should be one vertex, and vertices that lie on an edge of a
// neighbour.
#pragma once
#include "base/context.h"
#include "mesh/tri_mesh.h"
#include "mesh/validate.h"

namespace s3 {

/// Joins vertices of equal coordinates. Triangles that then repeat a corner are removed.
/// @return the places of the vertices that went
Defect weld_equal_vertices(TriMesh& mesh);

struct Stitched {
  Defect joined;      // vertices moved onto another
  Defect split;       // edges that got a vertex of the other side
  double widest = 0;  // mm, the farthest a vertex or an edge moved
};

/// Joins vertices of open edges, and splits open edges at vertices that lie on them, within
/// tolerances that grow from rounding errors to a thousandth of the diagonal, as long as this
/// leaves fewer open edges. Nothing moves farther than a third of the shortest edge around it, so
/// that no detail collapses. Vertices that are not on an open edge stay where they are.
Stitched stitch_open_edges(TriMesh& mesh, const Context* ctx);

/// Joins the ends of edges that are at most `length` long.
Defect collapse_short_edges(TriMesh& mesh, double length);

/// Removes triangles that are no higher than `height`: the triangles across the longest side are
/// split at the corner that lies on it, so that no gap opens.
/// @param height  mm; 0 for triangles that are exactly flat only
Defect remove_flat_triangles(TriMesh& mesh, double height);

}  // namespace s3
