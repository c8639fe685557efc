// Closest points, rays and boxes against many triangles: a flat tree of bounding boxes, four
// children a node.
#pragma once
#include <limits>
#include <vector>

#include "base/types.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// The point of a surface that is nearest to a query.
struct Closest {
  double distance = std::numeric_limits<double>::infinity();  // mm
  Vec3 point = Vec3::Zero();
  Index triangle = -1;              // −1: nothing within the asked distance
  Vec3 barycentric = Vec3::Zero();  // point = Σ barycentric_i · corner_i; sums to 1
};

struct RayHit {
  double t = std::numeric_limits<double>::infinity();  // hit = origin + t · direction
  Index triangle = -1;                                 // −1: none
};

/// Closest point of one triangle; right for triangles without area too.
Closest closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Triangles sorted into a tree once; all queries are const and may run on many threads.
/// Building takes O(n log n) time and about 150 bytes per triangle; the mesh is not referenced
/// afterwards.
class AabbTree {
 public:
  AabbTree() = default;
  /// @param triangles  #F×3 indices into vertices, all in range; triangles without area are welcome
  AabbTree(const Points& vertices, const Triangles& triangles);
  explicit AabbTree(const TriMesh& mesh) : AabbTree(mesh.vertices, mesh.triangles) {}

  bool empty() const { return faces_.empty(); }

  /// The nearest point with distance ≤ max_distance; a good bound (the answer of a neighbour plus
  /// the way to it, with a little slack) makes queries several times faster. At equal distances the
  /// triangle depends on the tree only.
  Closest closest(const Vec3& p,
                  double max_distance = std::numeric_limits<double>::infinity()) const;

  /// The first triangle hit by origin + t·direction with 0 ≤ t ≤ max_t, from either side.
  /// `direction` need not be a unit vector. Edges belong to both their triangles: a ray does not
  /// slip through a closed surface by more than rounding.
  RayHit first_hit(const Vec3& origin, const Vec3& direction,
                   double max_t = std::numeric_limits<double>::infinity()) const;
  /// All hits, by t.
  std::vector<RayHit> all_hits(const Vec3& origin, const Vec3& direction,
                               double max_t = std::numeric_limits<double>::infinity()) const;

  /// Replaces `found` by the triangles whose bounding boxes meet the box (touching counts), in no
  /// special order.
  void triangles_in_box(const Box& box, std::vector<Index>& found) const;

 private:
  struct Face {
    Vec3 a, ab, ac;  // corner and two edges
    Index triangle;
    bool flat;  // no area: closest() measures its edges
  };
  // Boxes of up to four children, rounded outwards to float: two cache lines. An unused slot's box
  // is empty.
  struct Node {
    float low[3][4], high[3][4];
    Index first[4];  // child node, or first face of a leaf
    Index count[4];  // faces of a leaf; 0 for a child node, negative for an unused slot
  };
  struct BuildItem;

  Index build(std::vector<BuildItem>& items, std::size_t begin, std::size_t end, int depth);

  std::vector<Node> nodes_;
  std::vector<Face> faces_;  // leaf by leaf
};

}  // namespace s3
