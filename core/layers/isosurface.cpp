// Marching tets on a piecewise linear field (Sec. 4.2), welded along the edges of the tet mesh.
#include "layers/isosurface.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace s3 {
namespace {

constexpr std::array<std::array<int, 2>, 6> kTetEdges = {
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
constexpr int kEdgeOf[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};

// For two corners above: the other two corners, such that (i, j, k, l) is an even permutation.
constexpr std::array<std::array<int, 4>, 6> kEvenPairs = {
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};

// Crossing points stay this share of the edge away from its ends (see extract()).
constexpr double kEndClearance = 1e-4;

}  // namespace

IsosurfaceExtractor::IsosurfaceExtractor(const TetMesh& rest, const ScalarField& field)
    : rest_(rest), field_(field) {
  if (field.value.size() > 0) {
    min_value_ = field.value.minCoeff();
    max_value_ = field.value.maxCoeff();
  }
  build_edges();
  build_bins();
  build_nodal_gradients();
}

void IsosurfaceExtractor::build_edges() {
  const Index tets = rest_.tet_count();
  // Bucket the edges by their smaller vertex, then sort and unify within each (small) bucket.
  std::vector<Index> begin(rest_.vertex_count() + 1, 0);
  const auto each_edge = [&](auto&& visit) {
    for (Index t = 0; t < tets; ++t)
      for (int e = 0; e < 6; ++e) {
        const Index a = rest_.tets(t, kTetEdges[e][0]), b = rest_.tets(t, kTetEdges[e][1]);
        visit(t, e, std::min(a, b), std::max(a, b));
      }
  };
  each_edge([&](Index, int, Index a, Index) { ++begin[a + 1]; });
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<Index> ends(static_cast<std::size_t>(tets) * 6);
  std::vector<Index> fill(begin.begin(), begin.end() - 1);
  each_edge([&](Index, int, Index a, Index b) { ends[fill[a]++] = b; });
  std::vector<Index> edge_begin(begin.size(), 0);
  Index count = 0;
  for (Index v = 0; v < rest_.vertex_count(); ++v) {
    const auto first = ends.begin() + begin[v], last = ends.begin() + begin[v + 1];
    std::sort(first, last);
    const auto unique_end = std::unique(first, last);
    edge_begin[v] = count;
    std::copy(first, unique_end, ends.begin() + count);
    count += static_cast<Index>(unique_end - first);
  }
  edge_begin.back() = count;
  edges_.resize(count, 2);
  for (Index v = 0; v < rest_.vertex_count(); ++v)
    for (Index e = edge_begin[v]; e < edge_begin[v + 1]; ++e) edges_.row(e) << v, ends[e];
  tet_edges_.resize(static_cast<std::size_t>(tets) * 6);
  each_edge([&](Index t, int e, Index a, Index b) {
    const auto found =
        std::lower_bound(ends.begin() + edge_begin[a], ends.begin() + edge_begin[a + 1], b);
    tet_edges_[static_cast<std::size_t>(t) * 6 + e] = static_cast<Index>(found - ends.begin());
  });
  edge_vertex_.assign(count, -1);
}

void IsosurfaceExtractor::build_bins() {
  const Index tets = rest_.tet_count();
  const auto range = [&](Index t) {
    double low = field_.value(rest_.tets(t, 0)), high = low;
    for (int i = 1; i < 4; ++i) {
      low = std::min(low, field_.value(rest_.tets(t, i)));
      high = std::max(high, field_.value(rest_.tets(t, i)));
    }
    return std::array<double, 2>{low, high};
  };
  double total = 0;
  for (Index t = 0; t < tets; ++t) total += range(t)[1] - range(t)[0];
  // Bins as wide as the mean range: a tet lies in about two of them, so the table stays linear in
  // the tets.
  bin_width_ = tets > 0 && total > 0 ? total / tets : 1;
  const double span = max_value_ - min_value_;
  const Index bins = 1 + static_cast<Index>(std::min<double>(span / bin_width_, tets));
  bin_width_ = std::max(bin_width_, span / bins * (1 + 1e-12));
  const auto bin = [&](double g) {
    return std::clamp(static_cast<Index>((g - min_value_) / bin_width_), Index{0}, bins - 1);
  };
  bin_begin_.assign(bins + 1, 0);
  for (Index t = 0; t < tets; ++t) {
    const auto [low, high] = range(t);
    for (Index b = bin(low); b <= bin(high); ++b) ++bin_begin_[b + 1];
  }
  for (Index b = 0; b < bins; ++b) bin_begin_[b + 1] += bin_begin_[b];
  bin_tets_.resize(bin_begin_.back());
  std::vector<Index> fill(bin_begin_.begin(), bin_begin_.end() - 1);
  for (Index t = 0; t < tets; ++t) {
    const auto [low, high] = range(t);
    for (Index b = bin(low); b <= bin(high); ++b) bin_tets_[fill[b]++] = t;
  }
}

void IsosurfaceExtractor::build_nodal_gradients() {
  nodal_gradient_ = Points::Zero(rest_.vertex_count(), 3);
  for (Index t = 0; t < rest_.tet_count(); ++t) {
    // The direction only, weighted by volume: a spot with a steep G must not decide its neighbours'
    // normals.
    const double volume = tet_volume(rest_.vertices, rest_.tets, t);
    for (int i = 0; i < 4; ++i)
      nodal_gradient_.row(rest_.tets(t, i)) += volume * field_.print_direction.row(t);
  }
  for (Index v = 0; v < rest_.vertex_count(); ++v) {
    const double length = nodal_gradient_.row(v).norm();
    if (length > 0) nodal_gradient_.row(v) /= length;
  }
}

Index IsosurfaceExtractor::crossing(Index edge, double iso, Isosurface& out) {
  Index& vertex = edge_vertex_[edge];
  if (vertex >= 0) return vertex;
  vertex = static_cast<Index>(used_edges_.size());
  used_edges_.push_back(edge);
  const Index a = edges_(edge, 0), b = edges_(edge, 1);
  const double s = std::clamp((iso - field_.value(a)) / (field_.value(b) - field_.value(a)),
                              kEndClearance, 1 - kEndClearance);
  if (vertex >= out.surface.vertices.rows()) {
    const Eigen::Index grown = std::max<Eigen::Index>(256, 2 * out.surface.vertices.rows());
    out.surface.vertices.conservativeResize(grown, 3);
    out.normal.conservativeResize(grown, 3);
  }
  out.surface.vertices.row(vertex) = (1 - s) * rest_.vertices.row(a) + s * rest_.vertices.row(b);
  out.normal.row(vertex) = (1 - s) * nodal_gradient_.row(a) + s * nodal_gradient_.row(b);
  return vertex;
}

Isosurface IsosurfaceExtractor::extract(double iso) {
  Isosurface out;
  if (!(iso > min_value_ && iso <= max_value_)) return out;
  const Index bins = static_cast<Index>(bin_begin_.size()) - 1;
  const Index bin =
      std::clamp(static_cast<Index>((iso - min_value_) / bin_width_), Index{0}, bins - 1);
  std::vector<std::array<Index, 3>> triangles;
  for (Index k = bin_begin_[bin]; k < bin_begin_[bin + 1]; ++k) {
    const Index t = bin_tets_[k];
    std::array<int, 4> above{}, below{};
    int n_above = 0, n_below = 0;
    for (int i = 0; i < 4; ++i)
      (field_.value(rest_.tets(t, i)) >= iso ? above[n_above++] : below[n_below++]) = i;
    if (n_above == 0 || n_below == 0) continue;
    const auto point = [&](int i, int j) {
      return crossing(tet_edges_[static_cast<std::size_t>(t) * 6 + kEdgeOf[i][j]], iso, out);
    };
    const auto emit = [&](Index a, Index b, Index c) {
      triangles.push_back({a, b, c});
      out.source_tet.push_back(t);
    };
    if (n_above == 2) {
      const auto& [i, j, k2, l] = kEvenPairs[kEdgeOf[above[0]][above[1]]];
      const Index ik = point(i, k2), jk = point(j, k2), jl = point(j, l), il = point(i, l);
      const auto& p = out.surface.vertices;
      if ((p.row(ik) - p.row(jl)).squaredNorm() <= (p.row(jk) - p.row(il)).squaredNorm()) {
        emit(ik, jk, jl);
        emit(ik, jl, il);
      } else {
        emit(ik, jk, il);
        emit(jk, jl, il);
      }
    } else {
      const int i = n_above == 1 ? above[0] : below[0];
      const Index a = point(i, kTetFaces[i][0]), b = point(i, kTetFaces[i][1]),
                  c = point(i, kTetFaces[i][2]);
      // Seen from the face opposite i, (a, b, c) is counter-clockwise: its normal points away from
      // i.
      n_above == 1 ? emit(a, c, b) : emit(a, b, c);
    }
  }
  const Eigen::Index count = static_cast<Eigen::Index>(used_edges_.size());
  out.surface.vertices.conservativeResize(count, 3);
  out.normal.conservativeResize(count, 3);
  out.surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t f = 0; f < triangles.size(); ++f)
    out.surface.triangles.row(static_cast<Eigen::Index>(f)) << triangles[f][0], triangles[f][1],
        triangles[f][2];
  for (const Index edge : used_edges_) edge_vertex_[edge] = -1;
  used_edges_.clear();
  for (Eigen::Index v = 0; v < count; ++v) {
    const double length = out.normal.row(v).norm();
    if (length > 1e-9)
      out.normal.row(v) /= length;
    else
      out.normal.row(v) = build_direction().transpose();
  }
  return out;
}

}  // namespace s3
