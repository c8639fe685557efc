// Bringing a layer's surface into the thickness range (Sec. 4.2, Step 3): what is too thin is left
// to later layers, what cannot be carried is left out.
#pragma once
#include <vector>

#include "base/context.h"
#include "layers/isosurface.h"
#include "layers/layer_distance.h"

namespace s3 {

/// Allowed distances to the printed material, mm.
struct ThicknessRange {
  double min, max;   // d_min, d_max
  double low, high;  // the same less a reserve: what is aimed for
  double gap_reach;  // what is farther than this starts in the air and stays, to be reported
  double far() const { return 4 * gap_reach; }  // distances are searched up to here
};

/// Distances of a surface's vertices to the material.
struct Measured {
  Values thickness;          // #V mm
  std::vector<Index> below;  // #V: the component that the nearest point belongs to, or the plate
  std::vector<char> on_rim;  // #V: the nearest point lies on that component's boundary
};

/// @param far  mm; what is farther is reported as being that far, above the plate
Measured measure(const PrintedMaterial& material, const Points& points, double far, Context& ctx);

/// Splits edges whose midpoint is outside [low, high] although its ends do not suggest it: above
/// the edge of a partial layer the thickness has a valley, and between two carriers a ridge, that
/// may lie between the vertices.
void refine_extremes(const PrintedMaterial& material, const ThicknessRange& range, double low,
                     double high, Isosurface& surface, Measured& distance, Context& ctx);

/// The thickest point of those connected pieces beyond d_max that are only slightly so and that a
/// somewhat lower isosurface would not have; places near `gaps` do not count. 0 where there are
/// none.
double slight_excess(const ThicknessRange& range, const Isosurface& surface,
                     const Measured& distance, const std::vector<Vec3>& gaps);

/// What trimming found.
struct Trimmed {
  double left_out_area = 0;           // mm² that nothing carries
  std::vector<Vec3> left_out_places;  // one a connected piece
  std::vector<Index> carriers;  // components nearest to points between the vertices, ascending
};

/// Cuts a remeshed surface so that corners, edge midpoints and centroids of all its triangles are
/// within [min, max] of the material. Pieces that reach beyond gap_reach stay, whole: without them
/// the next layers would hang over even more.
Trimmed trim_to_range(const PrintedMaterial& material, const ThicknessRange& range,
                      Isosurface& surface, Measured& distance, Context& ctx);

}  // namespace s3
