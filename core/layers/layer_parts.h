// Cutting layer surfaces: along a threshold, and into connected pieces (Sec. 4.2, Step 3).
#pragma once
#include <vector>

#include "layers/isosurface.h"

namespace s3 {

/// Undirected edges of a surface, each once, in the order in which the triangles name them.
struct SurfaceEdges {
  Pairs ends;             // #E×2
  Triangles of_triangle;  // #F×3: the edge from corner i to corner i+1
  explicit SurfaceEdges(const Triangles& triangles, Index vertices);
};

/// Splits marked edges at their midpoints; triangles with a marked edge become two, three or four.
///
/// New vertices follow the old ones, in the order of the marked edges.
/// @param marked  #E, of SurfaceEdges
Isosurface split_edges(const Isosurface& surface, const SurfaceEdges& edges,
                       const std::vector<char>& marked);

/// The part of a surface where the piecewise linear `value` (one a vertex) is not negative.
Isosurface cut_where_negative(const Isosurface& surface, const Values& value);

struct SurfacePart {
  Isosurface surface;
  std::vector<Index> vertices;  // #V: the vertex of the whole that each one was
};

/// Connected components, in the order of their first triangle.
std::vector<SurfacePart> split_components(const Isosurface& surface);

/// The triangles with a flag in their order, and their vertices.
SurfacePart extract_flagged(const Isosurface& surface, const std::vector<char>& flags);

}  // namespace s3
