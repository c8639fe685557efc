// Geodesic distance from a layer's boundary, the field whose iso-curves are the contour-parallel
// toolpaths (Sec. 5.1).
//
// Every vertex carries a *source*: the boundary edge it is nearest to and the rigid motion that
// unfolds the surface between the two into one plane. Sources travel from vertex to vertex in the
// order of their distance (Dijkstra), each step turning by the angle between the two normals. On a
// flat layer the distance is the exact Euclidean one; on a curved one the error is second order in
// (edge length × curvature). Because a source knows its edge, the distance can be evaluated between
// the vertices too, where it stays sharp across the medial axis.
#pragma once
#include <array>
#include <vector>

#include "base/context.h"
#include "base/types.h"

namespace s3 {

/// A triangulated layer with what toolpaths need at its vertices.
struct LayerMesh {
  Points vertices;    // #V×3 mm
  Directions normal;  // #V×3 unit
  Values thickness;   // #V mm
  Triangles triangles;
};
/// mm; 0 without triangles.
double longest_edge(const LayerMesh& layer);

/// Undirected edges of a triangle mesh, ascending by (lower vertex, higher vertex).
struct EdgeTable {
  std::vector<std::array<Index, 2>> ends;  // lower vertex first
  std::vector<std::array<Index, 3>>
      of_triangle;                              // #F: edge k joins the triangle's corners k and k+1
  std::vector<std::array<Index, 2>> triangles;  // the one or two triangles beside; −1 for none
};
EdgeTable make_edges(const Triangles& triangles, Index vertices);

/// Compressed rows: the neighbours of vertex v are neighbor[begin[v]] … neighbor[begin[v+1]-1].
struct VertexGraph {
  std::vector<Index> begin, neighbor;
};
VertexGraph make_vertex_graph(const std::vector<std::array<Index, 2>>& links, Index vertices);

/// The directed boundary edges of a layer, the surface to their left, chained into loops.
struct LayerBoundary {
  std::vector<Vec3> from, to;
  std::vector<Index> from_vertex;
  std::vector<Index> previous, next;  // edge numbers
  std::vector<Index> loop;            // of each edge
  std::vector<double> turn;  // rad, at the end of each edge: positive where the layer is convex
  /// Position of each edge's start along its loop. Reflex corners have a length too, fan_scale ×
  /// angle, so that every straight line leaving the boundary at a right angle has its own position.
  std::vector<double> position;
  std::vector<double> loop_length;  // one for each loop, with the fans
  double fan_scale = 0;             // mm per rad

  Index size() const { return static_cast<Index>(from.size()); }
};
LayerBoundary make_boundary(const LayerMesh& mesh, const EdgeTable& edges);

/// Where the distance at a vertex comes from: a boundary edge and the map p ↦ turn·p + shift from
/// the neighbourhood of the vertex to the plane in which the boundary lies when the surface between
/// them is unfolded.
struct BoundarySource {
  Index edge = -1;
  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

/// The nearest boundary point seen through one source.
struct BoundaryHit {
  double distance = 0;       // mm
  Vec3 away = Vec3::Zero();  // unit, from the boundary to the point; zero on the boundary
  Index edge = -1;
  double position = 0;  // along the loop, LayerBoundary::position
};

/// @param cross_corners  false: stay on the smooth piece of boundary that the source belongs to, so
/// that the distance
///                       on the far side of a medial axis can be compared with the near side's
/// @param slide  how many edges the nearest point may move on, on either side of the source's
BoundaryHit hit_boundary(const LayerBoundary& boundary, const BoundarySource& source,
                         const Vec3& point, bool cross_corners, int slide = 64);

/// The source of vertex `from`, carried over to a point with another normal.
BoundarySource carry_source(const BoundarySource& source, const Vec3& from, const Vec3& from_normal,
                            const Vec3& to, const Vec3& to_normal);

struct BoundaryDistance {
  Values distance;                     // #V mm; infinite where no boundary is connected
  Directions away;                     // #V×3: gradient of the distance; zero on the boundary
  std::vector<BoundarySource> source;  // #V
};

/// Cost O(#V log #V).
BoundaryDistance boundary_distance(const LayerMesh& mesh, const EdgeTable& edges,
                                   const LayerBoundary& boundary, const Context& ctx);

}  // namespace s3
