#include "mesh/fill_curved.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "math/sparse_solver.h"
#include "mesh/exact_predicates.h"

namespace s3 {

namespace {

using Triangle = std::array<Index, 3>;
using Edge = std::array<Index, 2>;

// The best triangulation costs n³ time; longer loops are cut in two first.
constexpr std::size_t kLongestLoop = 100;
constexpr double kDensity = std::numbers::sqrt2;  // Liepa's α
constexpr int kMaxRefinements = 12;
constexpr int kMaxFlipRounds = 12;
constexpr std::size_t kMostPoints = 100000;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

Edge edge(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

// Least bending, then least area.
struct Weight {
  double angle = 0, area = 0;  // rad, mm²
  bool operator<(const Weight& o) const {
    return angle != o.angle ? angle < o.angle : area < o.area;
  }
};

const Weight kImpossible{std::numeric_limits<double>::infinity(),
                         std::numeric_limits<double>::infinity()};

// Angles closer than this are equal: area decides.
constexpr double kAngleStep = 0.05;

double bending(const Vec3& n, const Vec3& m) {
  return kAngleStep * std::round(std::acos(std::clamp(n.dot(m), -1.0, 1.0)) / kAngleStep);
}

// Triangulates one loop by dynamic programming over its chords.
class Triangulation {
 public:
  // outward[i]: of the triangle behind loop[i] → loop[i+1]; zero where it is not known.
  Triangulation(const Points& points, std::vector<Index> loop, std::vector<Vec3> outward,
                const std::vector<Edge>& forbidden)
      : points_(points),
        loop_(std::move(loop)),
        outward_(std::move(outward)),
        forbidden_(forbidden),
        n_(loop_.size()),
        weight_(n_ * n_),
        middle_(n_ * n_, 0) {}

  std::vector<Triangle> triangles() {
    for (std::size_t step = 2; step < n_; ++step)
      for (std::size_t i = 0; i + step < n_; ++i) find_middle(i, i + step);
    std::vector<Triangle> result;
    if (!std::isfinite(weight_[n_ - 1].angle)) return result;
    std::vector<std::pair<std::size_t, std::size_t>> stack{{0, n_ - 1}};
    while (!stack.empty()) {
      const auto [i, k] = stack.back();
      stack.pop_back();
      if (k - i < 2) continue;
      const std::size_t m = middle_[i * n_ + k];
      result.push_back({loop_[i], loop_[m], loop_[k]});
      stack.emplace_back(i, m);
      stack.emplace_back(m, k);
    }
    return result;
  }

 private:
  Vec3 point(std::size_t i) const { return points_.row(loop_[i]); }

  // Normal of the triangle that the part i…k of the loop has at its chord, or of the mesh behind
  // the edge.
  Vec3 normal_at(std::size_t i, std::size_t k) const {
    if (k - i == 1) return outward_[i];
    const std::size_t m = middle_[i * n_ + k];
    return (point(m) - point(i)).cross(point(k) - point(i)).normalized();
  }

  void find_middle(std::size_t i, std::size_t k) {
    Weight best = kImpossible;
    std::size_t best_m = i + 1;
    const bool last = i == 0 && k == n_ - 1;
    if (last ||
        !std::binary_search(forbidden_.begin(), forbidden_.end(), edge(loop_[i], loop_[k]))) {
      for (std::size_t m = i + 1; m < k; ++m) {
        const Weight &left = weight_[i * n_ + m], &right = weight_[m * n_ + k];
        if (std::max(left.angle, right.angle) > best.angle) continue;
        const Vec3 cross = (point(m) - point(i)).cross(point(k) - point(i));
        const double area2 = cross.norm();
        if (!(area2 > 0) || is_degenerate({point(i), point(m), point(k)})) continue;
        const Vec3 normal = cross / area2;
        Weight w{std::max({left.angle, right.angle, bend(normal, normal_at(i, m)),
                           bend(normal, normal_at(m, k))}),
                 left.area + right.area + 0.5 * area2};
        if (last) w.angle = std::max(w.angle, bend(normal, outward_[n_ - 1]));
        if (w < best) best = w, best_m = m;
      }
    }
    weight_[i * n_ + k] = best;
    middle_[i * n_ + k] = best_m;
  }

  static double bend(const Vec3& n, const Vec3& m) { return m.isZero() ? 0 : bending(n, m); }

  const Points& points_;
  std::vector<Index> loop_;
  std::vector<Vec3> outward_;
  const std::vector<Edge>& forbidden_;
  std::size_t n_;
  std::vector<Weight> weight_;
  std::vector<std::size_t> middle_;
};

// The chord that cuts a long loop best: short for the way along the loop that it saves.
std::pair<std::size_t, std::size_t> best_cut(const Points& points, const std::vector<Index>& loop,
                                             const std::vector<Edge>& forbidden) {
  constexpr std::size_t kProbes = 64;
  const std::size_t n = loop.size();
  std::vector<double> along(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i)
    along[i + 1] = along[i] + (points.row(loop[(i + 1) % n]) - points.row(loop[i])).norm();
  double best = std::numeric_limits<double>::infinity();
  std::pair<std::size_t, std::size_t> cut{0, n / 2};
  for (std::size_t p = 0; p < kProbes; ++p) {
    const std::size_t i = p * n / kProbes;
    for (std::size_t j = i + n / 4; j <= i + 3 * n / 4 && j < n; ++j) {
      if (std::binary_search(forbidden.begin(), forbidden.end(), edge(loop[i], loop[j]))) continue;
      const double way = along[j] - along[i], round = std::min(way, along[n] - way);
      const double cost = (points.row(loop[i]) - points.row(loop[j])).norm() / round;
      if (cost < best) best = cost, cut = {i, j};
    }
  }
  return cut;
}

std::vector<Triangle> triangulated(const Points& points, const HoleRim& rim) {
  struct Loop {
    std::vector<Index> vertices;
    std::vector<Vec3> outward;
  };
  std::vector<Loop> loops{{rim.loop, rim.outward}};
  std::vector<Triangle> all;
  while (!loops.empty()) {
    Loop loop = std::move(loops.back());
    loops.pop_back();
    if (loop.vertices.size() <= kLongestLoop) {
      const auto part =
          Triangulation(points, std::move(loop.vertices), std::move(loop.outward), rim.edges)
              .triangles();
      if (part.empty()) return {};
      all.insert(all.end(), part.begin(), part.end());
      continue;
    }
    const auto [i, j] = best_cut(points, loop.vertices, rim.edges);
    Loop inner, outer;
    for (std::size_t v = 0; v < loop.vertices.size(); ++v) {
      const bool in_inner = v >= i && v < j;
      Loop& part = in_inner ? inner : outer;
      if (v == i) {  // the chord runs from i to j in the outer part
        outer.vertices.push_back(loop.vertices[i]);
        outer.outward.push_back(Vec3::Zero());
      }
      part.vertices.push_back(loop.vertices[v]);
      part.outward.push_back(loop.outward[v]);
      if (v + 1 == j) {
        inner.vertices.push_back(loop.vertices[j]);
        inner.outward.push_back(Vec3::Zero());
      }
    }
    loops.push_back(std::move(inner));
    loops.push_back(std::move(outer));
  }
  return all;
}

// The cap while it is refined: local numbers, the loop's vertices first.
class Cap {
 public:
  Cap(const Points& points, const HoleRim& rim, const std::vector<Triangle>& triangles)
      : rim_(rim), rim_size_(rim.loop.size()) {
    auto& local = local_;
    for (std::size_t i = 0; i < rim_size_; ++i) {
      points_.push_back(points.row(rim.loop[i]));
      local.emplace_back(rim.loop[i], static_cast<Index>(i));
      double sum = 0;
      for (const Index v : rim.neighbours[i])
        sum += (points.row(v).transpose() - points_[i]).norm();
      scale_.push_back(sum /
                       static_cast<double>(std::max<std::size_t>(1, rim.neighbours[i].size())));
    }
    std::sort(local.begin(), local.end());
    for (const Triangle& t : triangles) {
      Triangle mine;
      for (std::size_t i = 0; i < 3; ++i)
        mine[i] = std::lower_bound(local.begin(), local.end(), std::pair(t[i], Index{-1}))->second;
      triangles_.push_back(mine);
    }
    for (const Edge& e : rim.edges) {  // those between two vertices of the loop
      const auto a = std::lower_bound(local.begin(), local.end(), std::pair(e[0], Index{-1}));
      const auto b = std::lower_bound(local.begin(), local.end(), std::pair(e[1], Index{-1}));
      if (a != local.end() && b != local.end() && a->first == e[0] && b->first == e[1])
        taken_.insert(edge(a->second, b->second));
    }
  }

  void refine(Context& ctx) {
    for (int round = 0; round < kMaxRefinements && points_.size() < kMostPoints; ++round) {
      ctx.checkpoint();
      if (!split_large_triangles()) break;
      for (int i = 0; i < kMaxFlipRounds; ++i)
        if (!flip_round()) break;
    }
  }

  // Second-order umbrella: the differences of each vertex from the mean of its neighbours, the
  // loop's included, become as small as they can in the sense of least squares.
  void fair(const Points& mesh, Context& ctx) {
    const auto inner = static_cast<Index>(points_.size() - rim_size_);
    if (inner == 0) return;
    std::vector<Eigen::Triplet<double, Index>> entries;
    Block fixed = Block::Zero(static_cast<Eigen::Index>(points_.size()), 3);
    const std::vector<std::vector<Index>> around = neighbours();
    for (std::size_t v = 0; v < points_.size(); ++v) {
      std::vector<std::pair<Vec3, Index>> ring;  // place, unknown or −1
      for (const Index u : around[v])
        ring.emplace_back(points_[at(u)], u - static_cast<Index>(rim_size_));
      if (v < rim_size_)
        for (const Index u : rim_.neighbours[v])
          if (!in_loop(u)) ring.emplace_back(mesh.row(u), -1);
      double total = 0;
      for (const auto& [p, u] : ring) total += 1 / std::max((p - points_[v]).norm(), 1e-300);
      const auto row = static_cast<Index>(v);
      const auto add = [&](double weight, const Vec3& p, Index unknown) {
        if (unknown >= 0)
          entries.emplace_back(row, unknown, weight);
        else
          fixed.row(row) += weight * p.transpose();
      };
      for (const auto& [p, u] : ring)
        add(1 / std::max((p - points_[v]).norm(), 1e-300) / total, p, u);
      add(-1, points_[v], row - static_cast<Index>(rim_size_));
    }
    SparseMatrix L(static_cast<Eigen::Index>(points_.size()), inner);
    L.setFromTriplets(entries.begin(), entries.end());
    const SparseMatrix Lt = L.transpose();
    const auto solver = make_solver({.kind = SolverKind::ldlt});
    solver->factor(Lt * L, ctx);
    Block x = Block::Zero(inner, 3);
    solver->solve(-(Lt * fixed), x, ctx);
    if (!x.allFinite()) return;
    for (Index i = 0; i < inner; ++i) points_[rim_size_ + at(i)] = x.row(i).transpose();
  }

  CurvedFill result(Index first_new) const {
    CurvedFill fill;
    fill.points.assign(points_.begin() + static_cast<std::ptrdiff_t>(rim_size_), points_.end());
    for (const Triangle& t : triangles_) {
      Triangle global;
      for (std::size_t i = 0; i < 3; ++i)
        global[i] = at(t[i]) < rim_size_ ? rim_.loop[at(t[i])]
                                         : first_new + t[i] - static_cast<Index>(rim_size_);
      fill.triangles.push_back(global);
    }
    return fill;
  }

 private:
  bool in_loop(Index mesh_vertex) const {
    const auto it =
        std::lower_bound(local_.begin(), local_.end(), std::pair(mesh_vertex, Index{-1}));
    return it != local_.end() && it->first == mesh_vertex;
  }

  bool split_large_triangles() {
    const std::size_t old_count = triangles_.size();
    bool any = false;
    for (std::size_t f = 0; f < old_count; ++f) {
      const Triangle t = triangles_[f];
      const Vec3 center = (points_[at(t[0])] + points_[at(t[1])] + points_[at(t[2])]) / 3;
      const double scale = (scale_[at(t[0])] + scale_[at(t[1])] + scale_[at(t[2])]) / 3;
      bool large = true;
      for (const Index v : t) {
        const double d = kDensity * (center - points_[at(v)]).norm();
        large = large && d > scale && d > scale_[at(v)];
      }
      if (!large) continue;
      const auto c = static_cast<Index>(points_.size());
      points_.push_back(center);
      scale_.push_back(scale);
      triangles_[f] = {t[0], t[1], c};
      triangles_.push_back({t[1], t[2], c});
      triangles_.push_back({t[2], t[0], c});
      any = true;
    }
    return any;
  }

  struct HalfEdge {
    Edge key;
    Index triangle, corner;  // from corner to corner+1
    bool operator<(const HalfEdge& o) const {
      return key != o.key ? key < o.key : triangle < o.triangle;
    }
  };

  std::vector<HalfEdge> half_edges() const {
    std::vector<HalfEdge> all;
    for (std::size_t f = 0; f < triangles_.size(); ++f)
      for (std::size_t i = 0; i < 3; ++i)
        all.push_back({edge(triangles_[f][i], triangles_[f][(i + 1) % 3]), static_cast<Index>(f),
                       static_cast<Index>(i)});
    std::sort(all.begin(), all.end());
    return all;
  }

  double angle_at(Index tip, Index a, Index b) const {
    const Vec3 u = points_[at(a)] - points_[at(tip)], v = points_[at(b)] - points_[at(tip)];
    return std::atan2(u.cross(v).norm(), u.dot(v));
  }

  // Flips inner edges whose opposite angles sum to more than π; each triangle once.
  bool flip_round() {
    const std::vector<HalfEdge> all = half_edges();
    std::set<Edge> edges(taken_);
    for (const HalfEdge& h : all) edges.insert(h.key);
    std::vector<char> touched(triangles_.size(), 0);
    bool any = false;
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
      if (all[i].key != all[i + 1].key) continue;
      const auto f = at(all[i].triangle), g = at(all[i + 1].triangle);
      if (touched[f] || touched[g]) continue;
      const auto c = at(all[i].corner), d = at(all[i + 1].corner);
      const Index a = triangles_[f][c], b = triangles_[f][(c + 1) % 3],
                  p = triangles_[f][(c + 2) % 3], q = triangles_[g][(d + 2) % 3];
      if (angle_at(p, a, b) + angle_at(q, a, b) <= std::numbers::pi + 1e-9) continue;
      if (p == q || edges.count(edge(p, q)) > 0) continue;
      // Flipping across a bent quadrilateral must not fold it.
      const Vec3 pa = points_[at(a)], pb = points_[at(b)], pp = points_[at(p)], pq = points_[at(q)];
      const Vec3 n = (pb - pa).cross(pp - pa) + (pa - pb).cross(pq - pb);
      if ((pq - pa).cross(pp - pa).dot(n) <= 0 || (pb - pq).cross(pp - pq).dot(n) <= 0) continue;
      triangles_[f] = {a, q, p};
      triangles_[g] = {q, b, p};
      touched[f] = touched[g] = 1;
      edges.insert(edge(p, q));
      any = true;
    }
    return any;
  }

  std::vector<std::vector<Index>> neighbours() const {
    std::vector<std::vector<Index>> around(points_.size());
    for (const HalfEdge& h : half_edges()) {
      around[at(h.key[0])].push_back(h.key[1]);
      around[at(h.key[1])].push_back(h.key[0]);
    }
    for (auto& list : around) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return around;
  }

  const HoleRim& rim_;
  std::size_t rim_size_;
  std::vector<std::pair<Index, Index>> local_;  // sorted: vertex of the mesh, its local number
  std::vector<Vec3> points_;
  std::vector<double> scale_;  // mm, edge length to reach
  std::vector<Triangle> triangles_;
  std::set<Edge> taken_;  // edges of the mesh between vertices of the loop
};

}  // namespace

CurvedFill fill_curved(const Points& points, const HoleRim& rim, Index first_new, bool fair,
                       Context& ctx) {
  const std::vector<Triangle> triangles = triangulated(points, rim);
  if (triangles.empty() || !fair) return {{}, triangles};
  Cap cap(points, rim, triangles);
  cap.refine(ctx);
  cap.fair(points, ctx);
  return cap.result(first_new);
}

}  // namespace s3
