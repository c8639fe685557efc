// Iso-curves by marching triangles, all levels at once.
#include "toolpaths/bead_rings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace s3 {
namespace {

/// Curves u = k + ½, all levels at once. Every crossing of an edge and a level is a node with one
/// successor.
class RingTracer {
 public:
  RingTracer(const WorkLayer& layer, const BeadField& field) : layer_(layer), field_(field) {
    number_nodes();
    link_nodes();
  }

  /// Closed rings with the mesh vertex on their inner side.
  std::vector<PlannedPath> rings() const {
    std::vector<PlannedPath> result;
    std::vector<char> seen(next_.size(), 0);
    for (std::size_t start = 0; start < next_.size(); ++start) {
      if (seen[start]) continue;
      PlannedPath ring;
      std::vector<std::size_t> nodes;
      bool closed = false;
      for (auto i = static_cast<Index>(start); i >= 0; i = next_[static_cast<std::size_t>(i)]) {
        if (seen[static_cast<std::size_t>(i)]) {
          closed = static_cast<std::size_t>(i) == start;
          break;
        }
        seen[static_cast<std::size_t>(i)] = 1;
        nodes.push_back(static_cast<std::size_t>(i));
      }
      if (!closed || nodes.size() < 3) continue;
      ring.level = level_[start];
      ring.inner_vertex = high_[start];
      fill_ring(nodes, ring.path);
      result.push_back(std::move(ring));
    }
    return result;
  }

 private:
  void number_nodes() {
    const auto& ends = layer_.edges.ends;
    first_.resize(ends.size() + 1);
    first_level_.resize(ends.size());
    for (std::size_t e = 0; e < ends.size(); ++e) {
      const double ua = field_.coordinate(ends[e][0]), ub = field_.coordinate(ends[e][1]);
      const auto low = static_cast<Index>(std::floor(std::min(ua, ub) - 0.5)) + 1;
      const auto high = static_cast<Index>(std::floor(std::max(ua, ub) - 0.5));
      first_[e] = static_cast<Index>(level_.size());
      first_level_[e] = low;
      for (Index k = low; k <= high; ++k) {
        level_.push_back(k);
        edge_.push_back(static_cast<Index>(e));
        high_.push_back(ua > ub ? ends[e][0] : ends[e][1]);
      }
    }
    first_.back() = static_cast<Index>(level_.size());
  }

  void link_nodes() {
    next_.assign(level_.size(), -1);
    for (Eigen::Index f = 0; f < layer_.mesh.triangles.rows(); ++f) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (int k = 0; k < 3; ++k) {
        const double u = field_.coordinate(layer_.mesh.triangles(f, k));
        low = std::min(low, u);
        high = std::max(high, u);
      }
      const auto from = static_cast<Index>(std::floor(low - 0.5)) + 1,
                 to = static_cast<Index>(std::floor(high - 0.5));
      for (Index level = from; level <= to; ++level) {
        Index leaves = -1, enters = -1;
        for (int k = 0; k < 3; ++k) {
          const bool above = field_.coordinate(layer_.mesh.triangles(f, k)) >= level + 0.5;
          const bool above_next =
              field_.coordinate(layer_.mesh.triangles(f, (k + 1) % 3)) >= level + 0.5;
          if (above == above_next) continue;
          const auto e = static_cast<std::size_t>(
              layer_.edges.of_triangle[static_cast<std::size_t>(f)][static_cast<std::size_t>(k)]);
          (above ? leaves : enters) = first_[e] + level - first_level_[e];
        }
        next_[static_cast<std::size_t>(leaves)] = enters;  // the inner side is on the left
      }
    }
  }

  /// Where on the edge from a to b a ring crosses. The distance is straight between two vertices on
  /// one side of the axis, u has a bend at the ring: so by distance, unless the crossing comes from
  /// a change of the bead count.
  double fraction(Index a, Index b, Index level) const {
    const double below = layer_.field.distance(a) - field_.place_of(a, level);
    const double above = layer_.field.distance(b) - field_.place_of(b, level);
    if (below * above < 0) return below / (below - above);
    const double ua = field_.coordinate(a), ub = field_.coordinate(b);
    return std::clamp((level + 0.5 - ua) / (ub - ua), 0.0, 1.0);
  }

  void fill_ring(const std::vector<std::size_t>& nodes, Path& path) const {
    const auto n = static_cast<Eigen::Index>(nodes.size());
    path.closed = true;
    path.kind = PathKind::wall;
    path.points.resize(n, 3);
    path.normals.resize(n, 3);
    path.thickness.resize(n);
    path.width.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::size_t node = nodes[static_cast<std::size_t>(i)];
      const auto [a, b] = layer_.edges.ends[static_cast<std::size_t>(edge_[node])];
      const double t = fraction(a, b, level_[node]);
      path.points.row(i) = (1 - t) * layer_.mesh.vertices.row(a) + t * layer_.mesh.vertices.row(b);
      path.normals.row(i) =
          ((1 - t) * layer_.mesh.normal.row(a) + t * layer_.mesh.normal.row(b)).normalized();
      path.thickness(i) = (1 - t) * layer_.mesh.thickness(a) + t * layer_.mesh.thickness(b);
      path.width(i) =
          (1 - t) * field_.width_of(a, level_[node]) + t * field_.width_of(b, level_[node]);
    }
  }

  const WorkLayer& layer_;
  const BeadField& field_;
  std::vector<Index> first_, first_level_;         // by edge
  std::vector<Index> level_, edge_, high_, next_;  // by node
};

}  // namespace

BeadField make_bead_field(const WorkLayer& layer, const MedialPlan& medial, double width) {
  const auto n = layer.mesh.vertices.rows();
  BeadField field;
  field.width = width;
  field.coordinate.setZero(n);
  field.inner_ring.assign(static_cast<std::size_t>(n), -1);
  field.shift.setZero(n);
  for (Eigen::Index v = 0; v < n; ++v) {
    const double d = layer.field.distance(v);
    const BoundarySource& source = layer.field.source[static_cast<std::size_t>(v)];
    if (!(d > 0) || source.edge < 0) continue;
    const double plain = d / width;
    field.coordinate(v) = plain;
    const BeadPlan plan = medial.at(
        hit_boundary(layer.boundary, source, layer.mesh.vertices.row(v), true), layer.boundary);
    if (plan.weight <= 0) continue;
    const int whole_pairs = plan.beads / 2;
    const double pairs = whole_pairs;
    // The largest u on the axis: no ring there, and none more than the count says.
    const double top = plan.beads % 2 == 1 ? pairs + 0.4 : pairs;
    double fitted = plain;
    if (plan.beads < 2) {
      fitted = top * std::min(1.0, d / plan.radius);
    } else if (plain > pairs - 1) {
      const double outer = (pairs - 1) * width, ring = (pairs - 0.5) * width + plan.shift;
      if (d <= ring)
        fitted = pairs - 1 + 0.5 * (d - outer) / (ring - outer);
      else
        fitted = pairs - 0.5 +
                 (top - pairs + 0.5) *
                     std::clamp((d - ring) / std::max(plan.radius - ring, 1e-9 * width), 0.0, 1.0);
    }
    if (plan.beads >= 2) {
      field.inner_ring[static_cast<std::size_t>(v)] = static_cast<Index>(pairs) - 1;
      field.shift(v) = plan.weight * plan.shift;
    }
    field.coordinate(v) = plan.weight * fitted + (1 - plan.weight) * plain;
  }
  return field;
}

std::vector<PlannedPath> trace_rings(const WorkLayer& layer, const BeadField& field) {
  return RingTracer(layer, field).rings();
}

}  // namespace s3
