// Iso-curves by marching triangles on a bead coordinate u: u = d/w away from the medial axis, and
// stretched or squeezed for the innermost bead so that the beads fill the width exactly. Rings are
// the curves u = ½, 3/2, …
#include "toolpaths/contour_parallel.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "toolpaths/coverage.h"
#include "toolpaths/medial_axis.h"
#include "toolpaths/path_order.h"
#include "toolpaths/point_grid.h"
#include "toolpaths/simplify.h"

namespace s3 {
namespace {

constexpr double kLeastWidth = 0.4;  // of w: the narrowest bead
constexpr double kSimplify = 0.005;  // of w: how far a path may leave its exact place

/// The bead coordinate and the width of the innermost ring at the vertices.
struct BeadField {
  double width;                   // mm, w
  Values coordinate;              // #V: u
  std::vector<Index> inner_ring;  // #V: the ring that takes up the difference; −1 for none
  Values shift;                   // #V mm: how far that ring stands inside of its plain place

  double shift_of(Index vertex, Index ring) const {
    return inner_ring[static_cast<std::size_t>(vertex)] == ring ? shift(vertex) : 0;
  }
  /// Distance of a ring from the boundary, and its width, as seen from a vertex.
  double place_of(Index vertex, Index ring) const {
    return (ring + 0.5) * width + shift_of(vertex, ring);
  }
  double width_of(Index vertex, Index ring) const { return width + 2 * shift_of(vertex, ring); }
};

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

/// Removes points that the shape does not need.
void simplify(Path& path, double tolerance) {
  const Eigen::Index n = path.points.rows();
  if (n < 3) return;
  const std::vector<char> corner = find_path_corners(path, tolerance);
  std::vector<Eigen::Index> keep;
  for (Eigen::Index i = 0; i < n; ++i)
    if (corner[static_cast<std::size_t>(i)]) keep.push_back(i);
  // Tiny rings keep their points.
  if (keep.size() < (path.closed ? 3u : 2u)) return;
  Path kept;
  kept.closed = path.closed;
  kept.kind = path.kind;
  kept.points = path.points(keep, Eigen::all);
  kept.normals = path.normals(keep, Eigen::all);
  kept.thickness = path.thickness(keep);
  kept.width = path.width(keep);
  path = std::move(kept);
}

/// Single beads along the central pieces of the medial axis where the bead count is odd.
class AxisTracer {
 public:
  AxisTracer(const MedialAxis& axis, double width)
      : axis_(axis), width_(width), used_(axis.nodes.size(), 0) {}

  std::vector<PlannedPath> beads() {
    std::vector<PlannedPath> result;
    // Ends and branches first, so that whole chains are found; what is left are closed chains.
    for (const bool ends : {true, false})
      for (Index i = 0; i < static_cast<Index>(axis_.nodes.size()); ++i) {
        if (!single(i) || used_[static_cast<std::size_t>(i)] || (ends && degree(i) == 2)) continue;
        for (Index j = next(i, -1); j >= 0; j = ends ? next(i, -1) : -1) add_chain(i, j, result);
      }
    return result;
  }

 private:
  const MedialNode& node(Index i) const { return axis_.nodes[static_cast<std::size_t>(i)]; }
  bool single(Index i) const { return node(i).central && node(i).beads % 2 == 1; }
  /// What the rings on both sides leave.
  double width_of(Index i) const {
    const int pairs = node(i).beads / 2;
    return 2 * (node(i).radius - pairs * width_ - 2 * node(i).shift);
  }
  int degree(Index i) const {
    int count = 0;
    for (auto k = axis_.graph.begin[static_cast<std::size_t>(i)];
         k < axis_.graph.begin[static_cast<std::size_t>(i) + 1]; ++k)
      count += single(axis_.graph.neighbor[static_cast<std::size_t>(k)]);
    return count;
  }
  /// A neighbour that no chain has taken, and that is not where we come from.
  Index next(Index i, Index from) const {
    for (auto k = axis_.graph.begin[static_cast<std::size_t>(i)];
         k < axis_.graph.begin[static_cast<std::size_t>(i) + 1]; ++k) {
      const Index j = axis_.graph.neighbor[static_cast<std::size_t>(k)];
      if (j != from && single(j) && !used_[static_cast<std::size_t>(j)]) return j;
    }
    return -1;
  }
  /// Whether more beads follow where the chain ends in i.
  bool ends_in_more_beads(Index i) const {
    for (auto k = axis_.graph.begin[static_cast<std::size_t>(i)];
         k < axis_.graph.begin[static_cast<std::size_t>(i) + 1]; ++k) {
      const Index j = axis_.graph.neighbor[static_cast<std::size_t>(k)];
      if (node(j).central && node(j).beads > node(i).beads) return true;
    }
    return false;
  }

  void add_chain(Index first, Index second, std::vector<PlannedPath>& result) {
    std::vector<Index> chain = {first};
    used_[static_cast<std::size_t>(first)] = 1;
    bool closed = false;
    for (Index before = first, i = second; i >= 0;) {
      chain.push_back(i);
      used_[static_cast<std::size_t>(i)] = 1;
      // A branch ends here; its arms are chains of their own that start beside it.
      if (degree(i) != 2) break;
      const Index j = next(i, before);
      before = i;
      i = j;
    }
    if (chain.size() > 3 && degree(first) == 2 && degree(chain.back()) == 2) {
      const auto begin = axis_.graph.neighbor.begin() +
                         axis_.graph.begin[static_cast<std::size_t>(first)],
                 end = axis_.graph.neighbor.begin() +
                       axis_.graph.begin[static_cast<std::size_t>(first) + 1];
      closed = std::find(begin, end, chain.back()) != end;
    }
    if (!closed) trim(chain);
    // Crumbs between branches are left to HoleFiller.
    constexpr double kLeastLength = 0.5;  // of w
    double length = 0;
    for (std::size_t i = 1; i < chain.size(); ++i)
      length += (node(chain[i]).point - node(chain[i - 1]).point).norm();
    if (length < kLeastLength * width_) return;
    emit(chain, closed, result);
  }

  /// Where rings begin, the last of them turns across the axis and already fills the place.
  void trim(std::vector<Index>& chain) const {
    for (int end = 0; end < 2; ++end) {
      if (!chain.empty() && ends_in_more_beads(chain.back())) {
        double left = 0.8 * width_;
        while (chain.size() > 1 && left > 0) {
          left -= (node(chain.back()).point - node(chain[chain.size() - 2]).point).norm();
          chain.pop_back();
        }
        if (left > 0) chain.clear();
      }
      std::reverse(chain.begin(), chain.end());
    }
  }

  void emit(const std::vector<Index>& chain, bool closed, std::vector<PlannedPath>& result) const {
    PlannedPath bead;
    const auto n = static_cast<Eigen::Index>(chain.size());
    bead.level = node(chain.front()).beads / 2;
    bead.inner_vertex = node(chain.front()).vertex;
    bead.path.closed = closed;
    bead.path.kind = PathKind::gap_fill;
    bead.path.points.resize(n, 3);
    bead.path.normals.resize(n, 3);
    bead.path.thickness.resize(n);
    bead.path.width.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const MedialNode& from = node(chain[static_cast<std::size_t>(i)]);
      bead.path.points.row(i) = from.point;
      bead.path.normals.row(i) = from.normal;
      bead.path.thickness(i) = from.thickness;
      bead.path.width(i) = std::clamp(width_of(chain[static_cast<std::size_t>(i)]),
                                      kLeastWidth * width_, 2 * width_);
    }
    result.push_back(std::move(bead));
  }

  const MedialAxis& axis_;
  double width_;
  std::vector<char> used_;
};

double ring_length(const Path& ring) {
  double length = 0;
  const Eigen::Index n = ring.points.rows();
  for (Eigen::Index i = 0; i < n; ++i)
    length += (ring.points.row((i + 1) % n) - ring.points.row(i)).norm();
  return length;
}

/// Removes small rings that lie on a single bead: where the axis runs into a corner, both would
/// fill the same place.
void drop_rings_on_beads(std::vector<PlannedPath>& rings, const std::vector<PlannedPath>& beads,
                         double width) {
  constexpr double kSmallRing = 2.5;  // of w, length
  double widest = 0;
  for (const PlannedPath& bead : beads) widest = std::max(widest, bead.path.width.maxCoeff());
  if (widest == 0) return;
  PointGrid grid(0.5 * widest);
  std::vector<double> reach;
  for (const PlannedPath& bead : beads)
    for (Eigen::Index i = 0; i < bead.path.points.rows(); ++i) {
      grid.add(bead.path.points.row(i));
      reach.push_back(0.5 * bead.path.width(i));
    }
  grid.finish();
  const auto on_bead = [&](const PlannedPath& ring) {
    if (ring_length(ring.path) > kSmallRing * width) return false;
    Eigen::Index inside = 0;
    for (Eigen::Index i = 0; i < ring.path.points.rows(); ++i) {
      const Vec3 p = ring.path.points.row(i);
      bool near = false;
      grid.visit(p, [&](Index b) {
        near = near || (grid.point(b) - p).norm() < reach[static_cast<std::size_t>(b)];
      });
      inside += near;
    }
    return 2 * inside > ring.path.points.rows();
  };
  rings.erase(std::remove_if(rings.begin(), rings.end(), on_bead), rings.end());
}

/// Short beads in the holes that rings and axis beads leave: at triangular meeting points, and
/// around single maxima.
class HoleFiller {
 public:
  HoleFiller(const WorkLayer& layer, const Values& coordinate, const MedialAxis& axis, double width)
      : layer_(layer), coordinate_(coordinate), axis_(axis), width_(width), grid_(1) {}

  void fill(std::vector<PlannedPath>& paths) {
    double widest = width_;
    for (const PlannedPath& p : paths) widest = std::max(widest, p.path.width.maxCoeff());
    grid_ = PointGrid(0.5 * widest + kLargestRadius * width_);
    for (const PlannedPath& p : paths) add_points(p.path);
    grid_.finish();
    collect();
    std::sort(holes_.begin(), holes_.end(), [](const Hole& a, const Hole& b) {
      return a.radius != b.radius ? a.radius > b.radius : a.order < b.order;
    });
    std::vector<Hole> filled;
    for (Hole& hole : holes_) {
      for (const Hole& other : filled)
        hole.radius = std::min(hole.radius, (other.point - hole.point).norm() - other.radius);
      if (2 * hole.radius < kLeastWidth * width_) continue;
      filled.push_back(hole);
      paths.push_back(bead(hole));
    }
  }

 private:
  static constexpr double kLargestRadius = 0.6;  // of w
  struct Hole {
    Vec3 point, normal, along;
    double thickness, radius;
    Index vertex, order;
  };

  void add_points(const Path& path) {
    const Eigen::Index n = path.points.rows();
    for (Eigen::Index i = 0; i + 1 < n + (path.closed ? 1 : 0); ++i) {
      const Eigen::Index j = (i + 1) % n;
      const Vec3 a = path.points.row(i), b = path.points.row(j);
      const int pieces = 1 + static_cast<int>((b - a).norm() / (0.2 * width_));
      for (int k = 0; k <= pieces; ++k) {
        const double t = static_cast<double>(k) / pieces;
        grid_.add((1 - t) * a + t * b);
        reach_.push_back(0.5 * ((1 - t) * path.width(i) + t * path.width(j)));
      }
    }
  }

  /// Radius of the largest disc around a point that no bead touches.
  double clearance(const Vec3& p, double boundary_distance) const {
    double radius = std::min(kLargestRadius * width_, boundary_distance);
    grid_.visit(p, [&](Index i) {
      radius = std::min(radius, (grid_.point(i) - p).norm() - reach_[static_cast<std::size_t>(i)]);
    });
    return radius;
  }

  void add(Hole hole, double boundary_distance) {
    hole.radius = clearance(hole.point, boundary_distance);
    if (2 * hole.radius < kLeastWidth * width_) return;
    hole.order = static_cast<Index>(holes_.size());
    holes_.push_back(hole);
  }

  void collect() {
    for (std::size_t i = 0; i < axis_.nodes.size(); ++i) {
      const MedialNode& node = axis_.nodes[i];
      Vec3 along = node.normal.unitOrthogonal();
      if (axis_.graph.begin[i] < axis_.graph.begin[i + 1]) {
        const Index other = axis_.graph.neighbor[static_cast<std::size_t>(axis_.graph.begin[i])];
        const Vec3 way = axis_.nodes[static_cast<std::size_t>(other)].point - node.point;
        if (way.norm() > 1e-9 * width_) along = way.normalized();
      }
      add({node.point, node.normal, along, node.thickness, 0, node.vertex, 0}, node.radius);
    }
    std::vector<char> highest(static_cast<std::size_t>(layer_.mesh.vertices.rows()), 1);
    for (const auto& [a, b] : layer_.edges.ends)
      highest[static_cast<std::size_t>(
          layer_.field.distance(a) < layer_.field.distance(b) ? a : b)] = 0;
    for (Eigen::Index v = 0; v < layer_.mesh.vertices.rows(); ++v) {
      if (!highest[static_cast<std::size_t>(v)] || !std::isfinite(layer_.field.distance(v)))
        continue;
      const Vec3 normal = layer_.mesh.normal.row(v);
      add({layer_.mesh.vertices.row(v), normal, normal.unitOrthogonal(), layer_.mesh.thickness(v),
           0, static_cast<Index>(v), 0},
          layer_.field.distance(v));
    }
  }

  PlannedPath bead(const Hole& hole) const {
    PlannedPath planned;
    planned.level = static_cast<Index>(std::floor(coordinate_(hole.vertex) + 0.5));
    planned.inner_vertex = hole.vertex;
    Path& path = planned.path;
    path.kind = PathKind::gap_fill;
    path.points.resize(2, 3);
    // Long enough to be printed at all; its round ends do the rest.
    path.points.row(0) = hole.point - 0.4 * hole.radius * hole.along;
    path.points.row(1) = hole.point + 0.4 * hole.radius * hole.along;
    path.normals.resize(2, 3);
    path.normals.rowwise() = hole.normal.transpose();
    path.thickness.setConstant(2, hole.thickness);
    path.width.setConstant(2, 2 * hole.radius);
    return planned;
  }

  const WorkLayer& layer_;
  const Values& coordinate_;
  const MedialAxis& axis_;
  double width_;
  PointGrid grid_;
  std::vector<double> reach_;
  std::vector<Hole> holes_;
};

struct PlannedLayer {
  LayerPaths measured;  // without the paths
  PathTree tree;
};

PlannedLayer plan_layer(const Layer& layer, double width, const Context& ctx) {
  PlannedLayer result;
  LayerMesh mesh{layer.surface.vertices, layer.normal, layer.thickness, layer.surface.triangles};
  const WorkLayer work = prepare_layer(std::move(mesh), width, ctx);
  LayerPaths& measured = result.measured;
  if (work.boundary.size() == 0) {
    measured.area = measured.unfilled_thin_area = surface_area(layer.surface);
    return result;
  }
  const MedialPlan medial(work, width, ctx);
  const BeadField field = make_bead_field(work, medial, width);
  std::vector<PlannedPath> planned = RingTracer(work, field).rings();
  std::vector<PlannedPath> beads = AxisTracer(medial.axis(), width).beads();
  drop_rings_on_beads(planned, beads, width);
  std::move(beads.begin(), beads.end(), std::back_inserter(planned));
  for (PlannedPath& p : planned) simplify(p.path, kSimplify * width);
  HoleFiller(work, field.coordinate, medial.axis(), width).fill(planned);
  std::vector<Path> paths;
  paths.reserve(planned.size());
  for (const PlannedPath& p : planned) paths.push_back(p.path);
  // Measured on the layer as it came: its vertices are the first of the refined ones. Together with
  // the medial axis they are dense enough to tell where it is wide.
  const LayerMesh plain{layer.surface.vertices, layer.normal, layer.thickness,
                        layer.surface.triangles};
  const Values distance = work.field.distance.head(plain.vertices.rows());
  std::vector<InnerDisc> discs;
  for (Eigen::Index v = 0; v < plain.vertices.rows(); ++v)
    if (std::isfinite(distance(v))) discs.push_back({plain.vertices.row(v), distance(v)});
  for (std::size_t i = 0; i < medial.axis().nodes.size(); i += 2)
    discs.push_back({medial.axis().nodes[i].point, medial.axis().nodes[i].radius});
  const Coverage coverage =
      measure_coverage(plain, distance, discs, paths, width, kLeastWidth * width, ctx);
  measured.area = coverage.area;
  measured.covered_area = coverage.covered;
  measured.overlap_area = coverage.overlap;
  measured.wide_area = coverage.wide;
  measured.unfilled_thin_area = coverage.thin;
  result.tree = nest_paths(work, field.coordinate, std::move(planned));
  return result;
}

}  // namespace

LayerPaths contour_parallel(const Layer& layer, double width, const Context& ctx) {
  PlannedLayer planned = plan_layer(layer, width, ctx);
  LayerPaths result = std::move(planned.measured);
  const Vec3 start =
      layer.surface.vertices.rows() > 0 ? Vec3(layer.surface.vertices.row(0)) : Vec3(Vec3::Zero());
  result.paths = order_paths(planned.tree, start);
  return result;
}

Toolpaths make_toolpaths(const LayerStack& stack, const ToolpathParams& params,
                         double nozzle_diameter, Context& ctx) {
  const double width = params.width > 0 ? params.width : nozzle_diameter;
  if (!(width > 0) || !std::isfinite(width))
    throw Error(ErrorKind::input, Stage::toolpaths, "toolpaths.bad_width",
                "The bead width must be a positive length, not " + std::to_string(width) + " mm.",
                "Set toolpath.width or nozzle.diameter.");
  const std::size_t n = stack.layers.size();
  std::vector<PlannedLayer> planned(n);
  // In blocks, so that progress and cancel are seen from the stage's own thread.
  constexpr std::size_t kBlock = 16;
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t end = std::min(n, begin + kBlock);
    parallel_for(ctx.pool, end - begin, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = begin + first; i < begin + last; ++i)
        planned[i] = plan_layer(stack.layers[i], width, ctx);
    });
    ctx.progress(Stage::toolpaths, static_cast<double>(end) / static_cast<double>(n));
  }
  Toolpaths result;
  Vec3 seam = Vec3::Zero();
  double area = 0, thin_area = 0;
  std::vector<Vec3> empty;  // places of components without any path
  for (std::size_t i = 0; i < n; ++i) {
    LayerPaths layer = std::move(planned[i].measured);
    layer.component = static_cast<Index>(i);
    layer.paths = order_paths(planned[i].tree, seam);
    if (!layer.paths.empty()) seam = layer.paths.front().points.row(0);
    area += layer.area;
    if (layer.unfilled_thin_area > 0) {
      thin_area += layer.unfilled_thin_area;
      if (layer.paths.empty() && stack.layers[i].surface.vertices.rows() > 0)
        empty.push_back(stack.layers[i].surface.vertices.row(0));
    }
    result.layers.push_back(std::move(layer));
  }
  constexpr double kWorthAWarning = 0.002;  // of the whole area
  if (thin_area > kWorthAWarning * area)
    ctx.warn("toolpaths.thin_area",
             std::to_string(thin_area) + " mm² of " + std::to_string(area) +
                 " mm² of layers are too thin for a bead and stay empty; " +
                 std::to_string(empty.size()) +
                 " layer components have no path at all. A narrower toolpath.width fills more.",
             empty);
  return result;
}

}  // namespace s3
