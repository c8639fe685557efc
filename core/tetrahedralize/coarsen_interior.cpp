// Coarsening by contraction under a bound on quality: C. Ollivier-Gooch 2003, "Coarsening
// unstructured meshes by edge contraction".
#include "tetrahedralize/coarsen_interior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "tetrahedralize/quality.h"

namespace s3 {

namespace {

constexpr double kLeastSine = 0.2588190451025207;  // 15°
// Edges may be this many times as long as at the boundary, and longer by a share for each layer of
// vertices in between.
constexpr double kLongest = 1.5;
constexpr int kFirstDepth = 2;  // the tets of the boundary keep their shape
constexpr double kGrowth = 0.5;
constexpr int kMaxPasses = 40;
// Less than this decides nothing: rounding differs between platforms.
constexpr double kTie = 1e-6;

class InteriorCoarsener {
 public:
  InteriorCoarsener(const TetMesh& mesh, const Context& ctx) : ctx_(ctx), count_(mesh.tet_count()) {
    const auto n = static_cast<std::size_t>(mesh.vertex_count());
    points_.resize(n);
    star_.resize(n);
    for (std::size_t v = 0; v < n; ++v)
      points_[v] = mesh.vertices.row(static_cast<Eigen::Index>(v));
    tets_.resize(static_cast<std::size_t>(count_));
    for (Index t = 0; t < count_; ++t)
      for (int i = 0; i < 4; ++i) {
        tet(t)[static_cast<std::size_t>(i)] = mesh.tets(t, i);
        star(mesh.tets(t, i)).push_back(t);
      }
    find_depths(mesh);
    unit_ = mean_edge_length(mesh);
  }

  TetMesh run(Index target) {
    std::vector<Index> order(points_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return depth(a) > depth(b); });
    waiting_.assign(points_.size(), 1);
    for (int pass = 0; pass < kMaxPasses && count_ > target; ++pass)
      if (!remove_some(order, target)) break;
    return result();
  }

 private:
  using Corners = std::array<Index, 4>;

  const Vec3& at(Index v) const { return points_[static_cast<std::size_t>(v)]; }
  Corners& tet(Index t) { return tets_[static_cast<std::size_t>(t)]; }
  std::vector<Index>& star(Index v) { return star_[static_cast<std::size_t>(v)]; }
  int depth(Index v) const { return depth_[static_cast<std::size_t>(v)]; }

  // Edges to the boundary.
  void find_depths(const TetMesh& mesh) {
    depth_.assign(points_.size(), -1);
    std::vector<Index> queue;
    const auto reach = [&](Index v, int depth) {
      if (depth_[static_cast<std::size_t>(v)] >= 0) return;
      depth_[static_cast<std::size_t>(v)] = depth;
      queue.push_back(v);
    };
    for (Eigen::Index i = 0; i < mesh.boundary_faces.size(); ++i)
      reach(mesh.boundary_faces.data()[i], 0);
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const Index v = queue[head];
      for (const Index t : star(v))
        for (const Index u : tet(t)) reach(u, depth(v) + 1);
    }
  }

  // One pass: vertices none of which is beside another, so that tets grow evenly.
  bool remove_some(const std::vector<Index>& order, Index target) {
    ctx_.checkpoint();
    std::vector<char> touched(points_.size(), 0);
    bool any = false;
    for (const Index v : order) {
      if (count_ <= target) break;
      const auto i = static_cast<std::size_t>(v);
      if (depth(v) < kFirstDepth || touched[i] || !waiting_[i] || star(v).empty()) continue;
      waiting_[i] = 0;
      const std::vector<Index> ring = neighbors(v);
      if (!remove(v, ring)) continue;
      any = true;
      for (const Index u : ring)
        touched[static_cast<std::size_t>(u)] = waiting_[static_cast<std::size_t>(u)] = 1;
    }
    return any;
  }

  std::vector<Index> neighbors(Index v) {
    std::vector<Index> ring;
    for (const Index t : star(v))
      for (const Index u : tet(t))
        if (u != v) ring.push_back(u);
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
  }

  // The star of a vertex is filled anew from one of its neighbours, the one that sees all of its
  // outer faces best.
  bool remove(Index v, const std::vector<Index>& ring) {
    const double longest = unit_ * (kLongest + kGrowth * (depth(v) - 1));
    Index best = -1;
    double best_sine = kLeastSine;
    for (const Index to : ring) {
      const double sine = sine_from(v, to, ring, longest, best_sine);
      if (sine <= best_sine + (best < 0 ? 0 : kTie)) continue;
      best = to;
      best_sine = sine;
    }
    if (best < 0) return false;
    for (const Index t : star(v)) {
      Corners& c = tet(t);
      if (std::find(c.begin(), c.end(), best) == c.end()) {
        *std::find(c.begin(), c.end(), v) = best;
        star(best).push_back(t);
        continue;
      }
      for (const Index u : c)
        if (u != v) std::erase(star(u), t);
      c[0] = -1;
      --count_;
    }
    star(v).clear();
    return true;
  }

  // The least sine of the new tets when v goes to a neighbour; at most `enough` where it is not
  // worth knowing.
  double sine_from(Index v, Index to, const std::vector<Index>& ring, double longest,
                   double enough) {
    for (const Index u : ring)
      if ((at(u) - at(to)).squaredNorm() > longest * longest) return -1;
    double least = 1;
    for (const Index t : star(v)) {
      Corners c = tet(t);
      if (std::find(c.begin(), c.end(), to) != c.end()) continue;
      *std::find(c.begin(), c.end(), v) = to;
      least = std::min(least, least_sine(at(c[0]), at(c[1]), at(c[2]), at(c[3])));
      if (least <= enough) return least;
    }
    return least;
  }

  TetMesh result() const {
    std::vector<Index> number(points_.size(), -1);
    Index vertices = 0, row = 0;
    for (std::size_t v = 0; v < points_.size(); ++v)
      if (!star_[v].empty()) number[v] = vertices++;
    Points points(vertices, 3);
    for (std::size_t v = 0; v < points_.size(); ++v)
      if (number[v] >= 0) points.row(number[v]) = points_[v];
    Tets tets(count_, 4);
    for (const Corners& c : tets_) {
      if (c[0] < 0) continue;
      for (int i = 0; i < 4; ++i)
        tets(row, i) = number[static_cast<std::size_t>(c[static_cast<std::size_t>(i)])];
      ++row;
    }
    return make_tet_mesh(std::move(points), std::move(tets));
  }

  const Context& ctx_;
  std::vector<Vec3> points_;
  std::vector<Corners> tets_;             // first corner −1: gone
  std::vector<std::vector<Index>> star_;  // the tets at each vertex
  std::vector<int> depth_;
  std::vector<char> waiting_;  // something around has changed since the last try
  Index count_;
  double unit_ = 1;  // mm
};

}  // namespace

void coarsen_interior(TetMesh& mesh, Index target_tets, const Context& ctx) {
  if (mesh.tet_count() > target_tets) mesh = InteriorCoarsener(mesh, ctx).run(target_tets);
}

}  // namespace s3
