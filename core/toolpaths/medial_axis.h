// Where the two sides of a layer meet: the medial axis of its boundary distance, and how many beads
// fit across it.
//
// Contours at w/2, 3w/2, … leave a gap of up to one bead along the medial axis. The beads next to
// it are therefore as wide as what is left (Kuipers et al. 2020, "A framework for adaptive width
// control of dense contour-parallel toolpaths"): an even count 2m gives the innermost pair half of
// it each, an odd count 2m+1 a single bead along the axis. Only *central* pieces of the axis count,
// where the sides face each other; at a corner the contours simply turn.
#pragma once
#include <vector>

#include "toolpaths/boundary_distance.h"

namespace s3 {

constexpr double kLeastBeadWidth = 0.4;  // of w; what is thinner stays empty

/// Triangles of a layer after some of the splitting, and the given layer's triangle that each was.
struct SplitTriangles {
  Index vertices = 0;  // the first of the finest mesh's
  Triangles triangles;
  std::vector<Index> origin;  // #F
};

/// A layer ready for contours: refined where the medial axis passes.
struct WorkLayer {
  LayerMesh mesh;
  EdgeTable edges;
  LayerBoundary boundary;
  BoundaryDistance field;
  std::vector<Index> origin;  // #F: the triangle of the given layer
  SplitTriangles even;        // before the refinement near the medial axis: edges up to 1.2 w
};

/// Distance on a layer; triangles longer than the bead are split, and near the medial axis down to
/// a third of it. Given vertices stay the first.
WorkLayer prepare_layer(LayerMesh mesh, double width, const Context& ctx);

/// A point where the medial axis crosses a mesh edge, or the middle of a triangle where branches
/// meet.
struct MedialNode {
  Vec3 point, normal;
  double thickness = 0;
  double radius = 0;  // mm: distance to the boundary
  double opening = 0;  // rad: angle between the directions to the two sides; π in a strip, 90° at a
                       // square corner
  Index vertex = -1;  // a mesh vertex beside it
  Index beads = 0;    // across the axis; only where central
  double shift = 0;   // mm: how far the innermost ring stands inside of its plain place
  bool central = false;
};

struct MedialAxis {
  std::vector<MedialNode> nodes;
  std::vector<std::array<Index, 2>> links;  // one for each piece within a triangle
  VertexGraph graph;                        // the same by node
};

/// What the medial axis asks of a point: the half width of the layer there, and the beads across
/// it.
struct BeadPlan {
  double radius = 0;  // mm at the far end of the straight line from the boundary through the point
  Index beads = 0;    // across 2·radius
  double shift = 0;   // mm: how far the innermost ring stands inside of its plain place
  double weight =
      0;  // 1: the line ends on a central piece; 0: at a corner, where beads keep their width
};

class MedialPlan {
 public:
  MedialPlan(const WorkLayer& layer, double width, const Context& ctx);

  const MedialAxis& axis() const { return axis_; }
  /// @param hit  the boundary point nearest to the place in question
  BeadPlan at(const BoundaryHit& hit, const LayerBoundary& boundary) const;

 private:
  struct Sample {
    double position, radius;
    Index beads;
    bool central;
    double shift;
  };
  void find_nodes(const WorkLayer& layer, double width, const Context& ctx);
  void count_beads(double width);
  void place_inner_rings(double width);
  MedialAxis axis_;
  double width_;
  std::vector<std::array<Index, 2>> node_loop_;
  std::vector<std::array<double, 2>> node_position_;
  std::vector<std::vector<Sample>> samples_;  // by loop, ascending position
};

}  // namespace s3
