// Toolpaths on curved layers (Sec. 5.1): polylines on the layer surfaces, before resampling.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/types.h"

namespace s3 {

enum class PathKind : std::uint8_t { wall, infill, gap_fill };

/// "wall", "infill", "gap_fill": the text form in waypoints.csv and G-code comments.
const char* path_kind_name(PathKind kind);

struct Path {
  Points points;  // #P×3 mm on the layer's surface; a closed path does not repeat its first point
  Directions normals;  // #P×3 unit, from the layer
  Values thickness;    // #P mm: the bead's height
  Values width;        // #P mm: bead width
  bool closed = false;
  PathKind kind = PathKind::wall;
};

/// The path through some of a path's points, in the given order; kind and closing stay.
Path path_through(const Path& path, const std::vector<Eigen::Index>& points);

/// Area over a quantity in [0, 1], in equal bins: figures of layers add up to those of a stack.
struct ShareHistogram {
  static constexpr std::size_t kBins = 360;
  std::array<double, kBins> bins{};  // mm²

  void add(double position, double weight);
  void add(const ShareHistogram& other);
  double total() const;
  /// The position below which a share of the total lies, linear within a bin; total() > 0.
  double quantile(double share) const;
  /// Share of the total between two positions; total() > 0.
  double between(double low, double high) const;
};

/// How lines along the stress lie (line_quality.h); empty where there are none.
struct LineQuality {
  ShareHistogram deviation;  // from the projected τ_max within S: angle / 90°
  ShareHistogram spacing;    // between neighbouring strands: distance / 2w; the last bin: none
};

/// The paths of one layer component in print order, with what was measured on it.
struct LayerPaths {
  Index component = 0;  // position in LayerStack::layers
  std::vector<Path> paths;
  double area = 0;          // mm² of the layer's surface
  double covered_area = 0;  // mm² within half a bead width of a path
  double overlap_area = 0;  // mm² laid more than once, where the layer is wider than two beads
  double wide_area = 0;     // mm² of the part that is wider than two beads
  double unfilled_thin_area = 0;  // mm² too thin for one bead, nothing printed there
  LineQuality lines = {};
};

struct Toolpaths {
  std::vector<LayerPaths> layers;  // one for each component, in print order
};

}  // namespace s3
