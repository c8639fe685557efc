// Distances between layers (Sec. 4.2): surface to surface, exact.
#pragma once
#include <vector>

#include "base/context.h"
#include "base/types.h"
#include "layers/layer.h"
#include "mesh/aabb_tree.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// What has been printed so far: the plate z = 0 and the surfaces of earlier layer components. Each
/// surface is the upper side of the material beneath it.
class PrintedMaterial {
 public:
  static constexpr Index kPlate = -1;

  struct Nearest {
    double distance = 0;  // mm
    Index id = kPlate;    // as given to add()
    bool on_rim = false;  // the nearest point lies on the boundary of its surface
  };

  void add(const TriMesh& surface, Index id);

  /// The nearest material; {bound, kPlate} when nothing is nearer than `bound`.
  Nearest nearest(const Vec3& p, double bound) const;

  /// The way from p along a unit direction to the first material; `reach` where there is none
  /// within.
  double along(const Vec3& p, const Vec3& direction, double reach) const;

 private:
  struct Part {
    AabbTree tree;
    Box box;
    Index id;
    Triangles triangles;
    std::vector<char> on_rim;  // #V
  };
  std::vector<Part> parts_;
  std::vector<Box> group_boxes_;  // of kGroup parts each, so that most are passed over unseen
};

/// Thickness over the area of all layers, mm.
struct ThicknessReport {
  double min = 0, p1 = 0, p50 = 0, p99 = 0,
         max = 0;         // weighted by area; 0 for a stack without area
  double area = 0;        // mm² of all layers
  double thin_area = 0;   // mm² below d_min
  double thick_area = 0;  // mm² above d_max: nothing printed carries it
  double outside_percent() const { return area > 0 ? 100 * (thin_area + thick_area) / area : 0; }
};

/// Measures the thickness of every layer anew from the surfaces alone: at each triangle's corners,
/// edge midpoints and centroid, the distance to the nearest point of all layers with a smaller
/// number or of the plate.
/// @param d_min,d_max  mm, the range that counts as inside
ThicknessReport measure_thickness(const LayerStack& stack, double d_min, double d_max,
                                  Context& ctx);

}  // namespace s3
