// Iso-curves by marching triangles on a bead coordinate u: u = d/w away from the medial axis, and
// stretched or squeezed for the innermost bead so that the beads fill the width exactly. Rings are
// the curves u = ½, 3/2, …
#include "toolpaths/contour_parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "toolpaths/coverage.h"
#include "toolpaths/medial_axis.h"
#include "toolpaths/path_order.h"
#include "toolpaths/point_grid.h"

namespace s3 {
namespace {

constexpr double kLeastWidth = 0.4;  // of w: the narrowest bead

/// The bead coordinate and the width of the innermost ring at the vertices.
struct BeadField {
  Values coordinate;              // #V: u
  std::vector<Index> inner_ring;  // #V: the ring that takes up the difference; −1 for none
  Values inner_width;             // #V mm
  double width_of(Index vertex, Index ring, double width) const {
    return inner_ring[static_cast<std::size_t>(vertex)] == ring ? inner_width(vertex) : width;
  }
};

BeadField make_bead_field(const WorkLayer& layer, const MedialPlan& medial, double width) {
  const auto n = layer.mesh.vertices.rows();
  BeadField field;
  field.coordinate.setZero(n);
  field.inner_ring.assign(static_cast<std::size_t>(n), -1);
  field.inner_width.setConstant(n, width);
  for (Eigen::Index v = 0; v < n; ++v) {
    const double d = layer.field.distance(v);
    const BoundarySource& source = layer.field.source[static_cast<std::size_t>(v)];
    if (!(d > 0) || source.edge < 0) continue;
    const double plain = d / width;
    field.coordinate(v) = plain;
    const BeadPlan plan = medial.at(
        hit_boundary(layer.boundary, source, layer.mesh.vertices.row(v), true), layer.boundary);
    if (plan.weight <= 0) continue;
    const auto pairs = static_cast<double>(plan.beads / 2);
    double fitted = plain;
    if (plan.beads == 0) {
      fitted = std::min(plain, 0.45);
    } else if (plan.beads % 2 == 1) {
      // pairs·w of rings on this side, then half of the single bead
      const double rest = std::max(plan.radius - pairs * width, 1e-9 * width);
      if (plain > pairs) fitted = pairs + 0.45 * std::clamp((d - pairs * width) / rest, 0.0, 1.0);
    } else {
      // the innermost ring takes what is left
      const double rest = std::max(plan.radius - (pairs - 1) * width, 1e-9 * width);
      if (plain > pairs - 1) {
        fitted = pairs - 1 + std::clamp((d - (pairs - 1) * width) / rest, 0.0, 1.0);
        field.inner_ring[static_cast<std::size_t>(v)] = static_cast<Index>(pairs) - 1;
        field.inner_width(v) = plan.weight * rest + (1 - plan.weight) * width;
      }
    }
    field.coordinate(v) = plan.weight * fitted + (1 - plan.weight) * plain;
  }
  return field;
}

/// Curves u = k + ½, all levels at once. Every crossing of an edge and a level is a node with one
/// successor.
class RingTracer {
 public:
  RingTracer(const WorkLayer& layer, const BeadField& field, double width)
      : layer_(layer), field_(field), width_(width) {
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
      const double ua = field_.coordinate(a), ub = field_.coordinate(b);
      const double t = std::clamp((level_[node] + 0.5 - ua) / (ub - ua), 0.0, 1.0);
      path.points.row(i) = (1 - t) * layer_.mesh.vertices.row(a) + t * layer_.mesh.vertices.row(b);
      path.normals.row(i) =
          ((1 - t) * layer_.mesh.normal.row(a) + t * layer_.mesh.normal.row(b)).normalized();
      path.thickness(i) = (1 - t) * layer_.mesh.thickness(a) + t * layer_.mesh.thickness(b);
      path.width(i) = (1 - t) * field_.width_of(a, level_[node], width_) +
                      t * field_.width_of(b, level_[node], width_);
    }
  }

  const WorkLayer& layer_;
  const BeadField& field_;
  double width_;
  std::vector<Index> first_, first_level_;         // by edge
  std::vector<Index> level_, edge_, high_, next_;  // by node
};

/// Removes points that say nothing: nearer than `merge` to the one before.
void merge_close_points(Path& path, double merge) {
  std::vector<Eigen::Index> keep;
  const Eigen::Index n = path.points.rows();
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool last_of_open = !path.closed && i + 1 == n;
    if (!keep.empty() && (path.points.row(i) - path.points.row(keep.back())).norm() < merge) {
      if (!last_of_open || keep.size() == 1) continue;
      keep.back() = i;
      continue;
    }
    keep.push_back(i);
  }
  while (path.closed && keep.size() > 3 &&
         (path.points.row(keep.front()) - path.points.row(keep.back())).norm() < merge)
    keep.pop_back();
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
        if (degree(i) == 0) add_dot(i, result);
      }
    return result;
  }

 private:
  const MedialNode& node(Index i) const { return axis_.nodes[static_cast<std::size_t>(i)]; }
  bool single(Index i) const { return node(i).central && node(i).beads % 2 == 1; }
  double width_of(Index i) const { return 2 * (node(i).radius - (node(i).beads / 2) * width_); }
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
    if (chain.size() < 2) return;
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

  void add_dot(Index, std::vector<PlannedPath>&) const {}

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
  std::vector<PlannedPath> planned = RingTracer(work, field, width).rings();
  std::vector<PlannedPath> beads = AxisTracer(medial.axis(), width).beads();
  drop_rings_on_beads(planned, beads, width);
  std::move(beads.begin(), beads.end(), std::back_inserter(planned));
  std::vector<Path> paths;
  for (PlannedPath& p : planned) {
    merge_close_points(p.path, 0.03 * width);
    paths.push_back(p.path);
  }
  std::vector<InnerDisc> discs;
  for (Eigen::Index v = 0; v < work.mesh.vertices.rows(); ++v)
    if (std::isfinite(work.field.distance(v)))
      discs.push_back({work.mesh.vertices.row(v), work.field.distance(v)});
  for (const MedialNode& node : medial.axis().nodes) discs.push_back({node.point, node.radius});
  const Coverage coverage = measure_coverage(work.mesh, work.field.distance, discs, paths, width,
                                             kLeastWidth * width, ctx);
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
  result.paths = order_paths(std::move(planned.tree), start);
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
  std::atomic<std::size_t> done{0};
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
  for (std::size_t i = 0; i < n; ++i) {
    LayerPaths layer = std::move(planned[i].measured);
    layer.component = static_cast<Index>(i);
    layer.paths = order_paths(std::move(planned[i].tree), seam);
    if (!layer.paths.empty()) seam = layer.paths.front().points.row(0);
    result.layers.push_back(std::move(layer));
  }
  return result;
}

}  // namespace s3
