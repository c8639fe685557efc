// Where a layer has to be put between two others (Sec. 4.2, Step 2): where their distance is beyond
// d_max and there is room for one between them.
#pragma once
#include <vector>

#include "base/context.h"
#include "layers/isosurface.h"
#include "layers/trim_to_range.h"
#include "mesh/aabb_tree.h"
#include "mesh/tet_mesh.h"
#include "scalar_field/scalar_field.h"

namespace s3 {

/// The part's surface, as rays see it.
class PartSurface {
 public:
  /// Keeps a reference to the mesh.
  explicit PartSurface(const TetMesh& rest)
      : rest_(rest), tree_(rest.vertices, rest.boundary_faces) {}

  const AabbTree& tree() const { return tree_; }
  struct Exit {
    double distance;  // mm
    double cosine;    // between the direction and the surface's normal there; 0 where none is met
  };
  /// Where a way from a point along a unit direction leaves the part, {reach, 0} where it does not
  /// within. The point may stand off the part's surface by `tolerance`, mm.
  Exit leave(const Vec3& p, const Vec3& direction, double reach, double tolerance) const;

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
  Values above;  // to the layers above; far where the part ends before
  Values span;   // what is to be bridged: the thickness of the nearest layer above, or of the rest
                 // of the part if that is more
};

/// @param distance  of the surface to the material
Room measure_room(const Isosurface& surface, const Measured& distance, const LayersAbove& above,
                  const PartSurface& part, const ThicknessRange& range, Context& ctx);

/// Area where a span is beyond d_max, mm².
double area_beyond(const Isosurface& surface, const Values& span, const ThicknessRange& range);

/// Upward faces of the part that nearly are isosurfaces: what the last layer below them leaves of
/// the part is not a step but missing everywhere.
class Tops {
 public:
  Tops(const TetMesh& rest, const ScalarField& field);

  struct Choice {
    double iso = 0;
    double volume = 0;  // mm³ that a layer there fills below tops
  };
  /// Where one more layer between two iso values fills most, at least `least` mm above the lower.
  Choice between(double from, double to, double least) const;

 private:
  struct Face {
    double value, slope, area;  // of G, ‖∇G‖, mm²
  };
  std::vector<Face> faces_;  // by value
};

/// The parts of the isosurface right below tops that no layer above covers.
Isosurface below_tops(const Isosurface& surface, const Measured& distance, const LayersAbove& above,
                      const PartSurface& part, const ThicknessRange& range, double least_area,
                      Context& ctx);

/// The parts of the isosurface that close spans beyond d_max, each a whole one: they end where the
/// span alone would be a layer. Pieces smaller than `least_area` (mm²) are left out.
Isosurface insertion(const Isosurface& surface, const Room& room, const ThicknessRange& range,
                     double least_area);

}  // namespace s3
