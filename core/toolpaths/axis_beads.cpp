#include "toolpaths/axis_beads.h"

#include <algorithm>
#include <utility>

#include "toolpaths/point_grid.h"

namespace s3 {
namespace {

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
                                      kLeastBeadWidth * width_, 2 * width_);
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

}  // namespace

std::vector<PlannedPath> axis_beads(const MedialAxis& axis, double width) {
  return AxisTracer(axis, width).beads();
}

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

}  // namespace s3
