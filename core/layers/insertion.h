// Where a layer has to be put between two others (Sec. 4.2, Step 2): where their distance is beyond
// d_max and there is room for one between them.
#pragma once
#include <vector>

#include "base/context.h"
#include "layers/isosurface.h"
#include "layers/trim_to_range.h"
#include "mesh/aabb_tree.h"
#include "mesh/tet_mesh.h"

namespace s3 {

/// The part's surface, as rays see it.
class PartSurface {
 public:
  /// Keeps a reference to the mesh.
  explicit PartSurface(const TetMesh& rest)
      : rest_(rest), tree_(rest.vertices, rest.boundary_faces) {}

  const AabbTree& tree() const { return tree_; }
  /// The way from a point of the part along a unit direction to where the part ends, at most
  /// `reach`; `tolerance` from a point on the surface that leaves it at once.
  double way_out(const Vec3& p, const Vec3& direction, double reach, double tolerance) const;

 private:
  const TetMesh& rest_;
  AabbTree tree_;
};

/// Layers that are chosen but not printed yet, because others come below them.
class LayersAbove {
 public:
  struct Nearest {
    double distance;   // mm
    double thickness;  // mm, of that layer there
  };

  void push(const TriMesh& surface, const Values& thickness);
  void pop() { layers_.pop_back(); }
  /// {bound, 0} where no layer is nearer than `bound`.
  Nearest nearest(const Vec3& p, double bound) const;

 private:
  struct Entry {
    AabbTree tree;
    Triangles triangles;
    Values thickness;
  };
  std::vector<Entry> layers_;
};

/// The room that an isosurface has between what is printed and what comes above it; #V each, mm.
struct Room {
  Values below;  // to the material; where none is near, down to where the part ends
  Values above;  // to the layers above, or up to where the part ends
  Values span;   // what is to be bridged: the thickness of the layer above, or of the rest of the
                 // part
};

/// @param distance  of the surface to the material
Room measure_room(const Isosurface& surface, const Measured& distance, const LayersAbove& above,
                  const PartSurface& part, const ThicknessRange& range, Context& ctx);

/// Area where a span is beyond d_max, mm².
double area_beyond(const Isosurface& surface, const Values& span, const ThicknessRange& range);

/// The parts of the isosurface that close spans beyond d_max, each a whole one: they end where the
/// span alone would be a layer. Pieces smaller than `least_area` (mm²) are left out.
Isosurface insertion(const Isosurface& surface, const Room& room, const ThicknessRange& range,
                     double least_area);

}  // namespace s3
