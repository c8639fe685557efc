// Distance from a point of a layer to the material printed before it (Sec. 4.2): surface to
// surface, exact.
#pragma once
#include <array>
#include <vector>

#include "base/types.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// Triangles in a box hierarchy, for closest-point distances. Keeps its own copy of the corners.
class SurfaceTree {
 public:
  explicit SurfaceTree(const TriMesh& surface);

  struct Closest {
    double distance = 0;
    Index triangle = -1;  // −1: nothing nearer than the bound
    Vec3 point = Vec3::Zero();
  };
  /// The closest point of the surface if it is nearer than `bound`.
  Closest closest(const Vec3& p, double bound) const;
  /// Distance from p to the box of the whole surface; 0 inside.
  double box_distance(const Vec3& p) const;

 private:
  struct Node {
    Vec3 min, max;
    Index left = -1;  // children left and left + 1; −1 for a leaf
    Index begin = 0, end = 0;
  };
  void build(Index node, std::vector<Index>& order, const std::vector<Vec3>& centers);
  static double box_distance_squared(const Node& node, const Vec3& p);

  std::vector<Node> nodes_;
  std::vector<std::array<Vec3, 3>> corners_;  // in leaf order
  std::vector<Index> triangle_;               // leaf order → triangle of the surface
};

/// What has been printed so far: the plate z = 0 and the surfaces of all earlier layers. Each
/// surface is the upper side of the material beneath it.
class PrintedMaterial {
 public:
  void add(const TriMesh& surface) { trees_.emplace_back(surface); }
  bool empty() const { return trees_.empty(); }

  /// Distance to the nearest material, mm; `bound` itself when nothing is nearer than it.
  double distance(const Vec3& p, double bound) const;

 private:
  std::vector<SurfaceTree> trees_;
};

}  // namespace s3
