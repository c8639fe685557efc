// Half-edge contraction with a two-sided bound: J. Cohen et al. 1996, "Simplification Envelopes",
// in the sampled form of R. Klein, G. Liebich, W. Strasser 1996, "Mesh Reduction with Error
// Control".
#include "tetrahedralize/coarsen_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

#include "mesh/aabb_tree.h"
#include "tetrahedralize/feature_curves.h"

namespace s3 {

namespace {

// Shares of the wanted edge: shorter edges are contracted, and much shorter ones also off sharp
// edges and corners.
constexpr double kShort = 0.65;
constexpr double kTiny = 0.15;
// Triangles may turn by less than the angle of this cosine, 50°.
constexpr double kTurnCosine = 0.6427876096865394;
// Shapes, 1 for an equilateral triangle: contraction must not make worse ones, flips work on worse
// ones and must improve them by this factor.
constexpr double kKeepShape = 0.35;
constexpr double kFlipShape = 0.6;
constexpr double kFlipGain = 1.05;
constexpr double kLongest = 4.0 / 3;  // of the wanted edge, unless there was a longer one before,
constexpr double kStretch = 1.05;     // times this
constexpr int kRounds = 4;
constexpr std::size_t kCheckEvery = 1024;
constexpr Index kNone = -1;

using Corners = std::array<Index, 3>;

double shape(const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr double kEquilateral = 3.4641016151377544;  // 2√3
  const double sum = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
  return sum > 0 ? kEquilateral * (b - a).cross(c - a).norm() / sum : 0;
}

class Coarsener {
 public:
  Coarsener(const TriMesh& surface, double edge, double tolerance, const Context& ctx)
      : given_(surface), edge_(edge), tolerance_(tolerance), ctx_(ctx) {
    const auto vertices = static_cast<std::size_t>(surface.vertices.rows()),
               triangles = static_cast<std::size_t>(surface.triangles.rows());
    points_.resize(vertices);
    fan_.resize(vertices);
    for (std::size_t v = 0; v < vertices; ++v)
      points_[v] = surface.vertices.row(static_cast<Eigen::Index>(v));
    corners_.resize(triangles);
    samples_.resize(triangles);
    for (std::size_t f = 0; f < triangles; ++f) {
      for (std::size_t i = 0; i < 3; ++i) {
        corners_[f][i] =
            surface.triangles(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(i));
        fan_[static_cast<std::size_t>(corners_[f][i])].push_back(static_cast<Index>(f));
      }
      add_samples(f);
    }
  }

  TriMesh run() {
    for (int round = 0; round < kRounds; ++round) {
      const bool contracted = contract_short_edges(), flipped = flip_flat_triangles();
      if (!contracted && !flipped) break;
    }
    return result();
  }

 private:
  struct Short {
    double length2;
    Index a, b;  // a < b
    bool operator<(const Short& o) const {
      return std::tie(length2, a, b) > std::tie(o.length2, o.a, o.b);
    }
  };

  const Vec3& at(Index v) const { return points_[static_cast<std::size_t>(v)]; }
  const Corners& corners(Index f) const { return corners_[static_cast<std::size_t>(f)]; }
  std::vector<Index>& fan(Index v) { return fan_[static_cast<std::size_t>(v)]; }
  bool is_alive(Index f) const { return corners(f)[0] != kNone; }
  double shape_of(const Corners& c) const { return shape(at(c[0]), at(c[1]), at(c[2])); }
  Vec3 normal_of(const Corners& c) const {
    return (at(c[1]) - at(c[0])).cross(at(c[2]) - at(c[0])).normalized();
  }
  static bool has(const Corners& c, Index v) { return c[0] == v || c[1] == v || c[2] == v; }

  // Middles of the triangle and of the edges that it owns.
  void add_samples(std::size_t f) {
    const Corners& c = corners_[f];
    samples_[f].push_back((at(c[0]) + at(c[1]) + at(c[2])) / 3);
    for (std::size_t i = 0; i < 3; ++i)
      if (c[i] < c[(i + 1) % 3]) samples_[f].push_back(0.5 * (at(c[i]) + at(c[(i + 1) % 3])));
  }

  // The vertices around v, sorted.
  std::vector<Index> neighbors(Index v) {
    std::vector<Index> ring;
    for (const Index f : fan(v))
      for (const Index u : corners(f))
        if (u != v) ring.push_back(u);
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
  }

  // The two triangles of an edge; the first runs from a to b.
  std::array<Index, 2> triangles_of(Index a, Index b) {
    std::array<Index, 2> both{kNone, kNone};
    for (const Index f : fan(a)) {
      const Corners& c = corners(f);
      for (std::size_t i = 0; i < 3; ++i) {
        if (c[i] == a && c[(i + 1) % 3] == b) both[0] = f;
        if (c[i] == b && c[(i + 1) % 3] == a) both[1] = f;
      }
    }
    return both;
  }

  static Index third(const Corners& c, Index a, Index b) {
    for (const Index v : c)
      if (v != a && v != b) return v;
    return kNone;
  }

  bool is_sharp(Index a, Index b) {
    const auto [f, g] = triangles_of(a, b);
    return f == kNone || g == kNone ||
           normal_of(corners(f)).dot(normal_of(corners(g))) < kSharpCosine;
  }

  // Whether a may go to b without leaving a sharp edge.
  bool keeps_features(Index a, Index b, const std::vector<Index>& around_a) {
    int sharp = 0;
    bool along = false;
    for (const Index v : around_a)
      if (is_sharp(a, v)) {
        ++sharp;
        along = along || v == b;
      }
    return sharp == 0 || (sharp == 2 && along);
  }

  // --- distance ----------------------------------------------------------------------------------

  bool is_near_given(const Corners& c) const {
    const Vec3 &p = at(c[0]), &q = at(c[1]), &r = at(c[2]);
    for (const Vec3& sample :
         {Vec3((p + q + r) / 3), Vec3((p + q) / 2), Vec3((q + r) / 2), Vec3((r + p) / 2)})
      if (given_tree_.closest(sample, tolerance_).triangle < 0) return false;
    return true;
  }

  // The one of some triangles that is nearest to a sample. @return kNone if all are too far
  int nearest(const Vec3& sample, const std::vector<Corners>& made) const {
    double least = tolerance_;
    int best = kNone;
    for (std::size_t i = 0; i < made.size(); ++i) {
      const double d =
          closest_on_triangle(sample, at(made[i][0]), at(made[i][1]), at(made[i][2])).distance;
      if (d > least) continue;
      least = d;
      best = static_cast<int>(i);
    }
    return best;
  }

  // Whether triangles may stand for others, apart from shape: within the tolerance in both
  // directions. Fills `homes`: for each sample of the old ones its new triangle.
  bool may_replace(const std::vector<Index>& old, const std::vector<Corners>& made,
                   const std::vector<Vec3>& more, std::vector<std::pair<int, Vec3>>& homes) const {
    homes.clear();
    const auto take_in = [&](const Vec3& sample) {
      homes.emplace_back(nearest(sample, made), sample);
      return homes.back().first != kNone;
    };
    for (const Vec3& sample : more)
      if (!take_in(sample)) return false;
    for (const Index f : old)
      for (const Vec3& sample : samples_[static_cast<std::size_t>(f)])
        if (!take_in(sample)) return false;
    return std::all_of(made.begin(), made.end(),
                       [&](const Corners& c) { return is_near_given(c); });
  }

  // --- contraction -------------------------------------------------------------------------------

  bool contract_short_edges() {
    std::priority_queue<Short> queue;
    const double limit2 = kShort * edge_ * kShort * edge_;
    const auto offer = [&](Index a, Index b) {
      const double length2 = (at(a) - at(b)).squaredNorm();
      if (length2 < limit2) queue.push({length2, std::min(a, b), std::max(a, b)});
    };
    for (const Corners& c : corners_)
      for (std::size_t i = 0; c[0] != kNone && i < 3; ++i)
        if (c[i] < c[(i + 1) % 3]) offer(c[i], c[(i + 1) % 3]);
    bool any = false;
    for (std::size_t step = 0; !queue.empty(); ++step) {
      if (step % kCheckEvery == 0) ctx_.checkpoint();
      const Short top = queue.top();
      queue.pop();
      if (fan(top.a).empty() || fan(top.b).empty() || triangles_of(top.a, top.b)[0] == kNone)
        continue;
      const Index left = contract(top.a, top.b);
      if (left == kNone) continue;
      any = true;
      for (const Index v : neighbors(left)) offer(left, v);
    }
    return any;
  }

  // Contracts an edge to one of its ends, better the one that leaves the better triangles. @return
  // the end that is left, or kNone
  Index contract(Index a, Index b) {
    const std::vector<Index> around_a = neighbors(a), around_b = neighbors(b);
    std::vector<Index> common;
    std::set_intersection(around_a.begin(), around_a.end(), around_b.begin(), around_b.end(),
                          std::back_inserter(common));
    // The surface stays a manifold: only the ends of the edge's triangles see both of its ends.
    if (common.size() != 2) return kNone;
    for (const Index v : common)
      if (fan(v).size() < 4) return kNone;
    const bool tiny = (at(a) - at(b)).squaredNorm() < kTiny * edge_ * kTiny * edge_;
    Contraction to_b = plan(a, b), to_a = plan(b, a);
    if (!tiny && !keeps_features(a, b, around_a)) to_b.shape = -1;
    if (!tiny && !keeps_features(b, a, around_b)) to_a.shape = -1;
    for (int i = 0; i < 2; ++i) {
      Contraction& better = to_b.shape >= to_a.shape ? to_b : to_a;
      if (better.shape < 0) return kNone;
      if (carry_out(better)) return better.to;
      better.shape = -1;
    }
    return kNone;
  }

  struct Contraction {
    Index from, to;
    double shape = -1;          // of the worst new triangle; negative: not allowed
    std::vector<Corners> made;  // in the order of the fan without the edge's triangles
  };

  Contraction plan(Index from, Index to) {
    Contraction c{from, to, 1, {}};
    double before = 1, longest2 = kLongest * kLongest * edge_ * edge_;
    for (const Index f : fan(from)) {
      before = std::min(before, shape_of(corners(f)));
      for (const Index v : corners(f))
        longest2 = std::max(longest2, (at(v) - at(from)).squaredNorm());
    }
    for (const Index f : fan(from)) {
      if (has(corners(f), to)) continue;
      Corners made = corners(f);
      for (Index& v : made) {
        if ((at(v) - at(to)).squaredNorm() > kStretch * kStretch * longest2)
          return {from, to, -1, {}};
        if (v == from) v = to;
      }
      // The normal of a needle says nothing.
      const bool has_normal = shape_of(corners(f)) > 0.02;
      if (has_normal && normal_of(made).dot(normal_of(corners(f))) < kTurnCosine)
        return {from, to, -1, {}};
      c.shape = std::min(c.shape, shape_of(made));
      c.made.push_back(made);
    }
    if (c.shape < std::min(kKeepShape, before)) c.shape = -1;
    return c;
  }

  bool carry_out(const Contraction& c) {
    std::vector<std::pair<int, Vec3>> homes;
    if (!may_replace(fan(c.from), c.made, {at(c.from)}, homes)) return false;
    const std::vector<Index> old = fan(c.from);
    std::vector<Index> kept;
    for (const Index f : old) {
      samples_[static_cast<std::size_t>(f)].clear();
      if (!has(corners(f), c.to)) {
        corners_[static_cast<std::size_t>(f)] = c.made[kept.size()];
        kept.push_back(f);
        fan(c.to).push_back(f);
        continue;
      }
      for (const Index v : corners(f)) std::erase(fan(v), f);
      corners_[static_cast<std::size_t>(f)] = {kNone, kNone, kNone};
    }
    fan(c.from).clear();
    for (const auto& [home, sample] : homes)
      samples_[static_cast<std::size_t>(kept[static_cast<std::size_t>(home)])].push_back(sample);
    return true;
  }

  // --- flips -------------------------------------------------------------------------------------

  bool flip_flat_triangles() {
    bool any = false;
    for (std::size_t f = 0; f < corners_.size(); ++f) {
      if (f % kCheckEvery == 0) ctx_.checkpoint();
      if (!is_alive(static_cast<Index>(f)) || shape_of(corners_[f]) > kFlipShape) continue;
      // The longest edge.
      const Corners c = corners_[f];
      std::size_t longest = 0;
      for (std::size_t i = 1; i < 3; ++i)
        if ((at(c[i]) - at(c[(i + 1) % 3])).squaredNorm() >
            (at(c[longest]) - at(c[(longest + 1) % 3])).squaredNorm())
          longest = i;
      any = flip(c[longest], c[(longest + 1) % 3]) || any;
    }
    return any;
  }

  bool flip(Index a, Index b) {
    const auto [f, g] = triangles_of(a, b);
    if (f == kNone || g == kNone) return false;
    const Index c = third(corners(f), a, b), d = third(corners(g), a, b);
    if (c == d || fan(a).size() < 4 || fan(b).size() < 4 || triangles_of(c, d)[0] != kNone)
      return false;
    const std::vector<Corners> made{{a, d, c}, {d, b, c}};
    const double before = std::min(shape_of(corners(f)), shape_of(corners(g))),
                 after = std::min(shape_of(made[0]), shape_of(made[1]));
    if (after < kFlipGain * before) return false;
    for (const Index old : {f, g})
      for (const Corners& m : made)
        if (shape_of(corners(old)) > 0.02 &&
            normal_of(m).dot(normal_of(corners(old))) < kTurnCosine)
          return false;
    std::vector<std::pair<int, Vec3>> homes;
    if (!may_replace({f, g}, made, {}, homes)) return false;
    std::erase(fan(a), g);
    std::erase(fan(b), f);
    fan(c).push_back(g);
    fan(d).push_back(f);
    corners_[static_cast<std::size_t>(f)] = made[0];
    corners_[static_cast<std::size_t>(g)] = made[1];
    samples_[static_cast<std::size_t>(f)].clear();
    samples_[static_cast<std::size_t>(g)].clear();
    for (const auto& [home, sample] : homes)
      samples_[static_cast<std::size_t>(home == 0 ? f : g)].push_back(sample);
    return true;
  }

  TriMesh result() {
    std::vector<Index> number(points_.size(), kNone);
    TriMesh mesh;
    Index vertices = 0, triangles = 0;
    for (std::size_t v = 0; v < points_.size(); ++v)
      if (!fan_[v].empty()) number[v] = vertices++;
    mesh.vertices.resize(vertices, 3);
    for (std::size_t v = 0; v < points_.size(); ++v)
      if (number[v] != kNone) mesh.vertices.row(number[v]) = points_[v];
    mesh.triangles.resize(static_cast<Eigen::Index>(corners_.size()), 3);
    for (const Corners& c : corners_)
      if (c[0] != kNone)
        mesh.triangles.row(triangles++) << number[static_cast<std::size_t>(c[0])],
            number[static_cast<std::size_t>(c[1])], number[static_cast<std::size_t>(c[2])];
    mesh.triangles.conservativeResize(triangles, 3);
    return mesh;
  }

  const TriMesh& given_;
  const AabbTree given_tree_{given_};
  const double edge_, tolerance_;
  const Context& ctx_;

  std::vector<Vec3> points_;
  std::vector<Corners> corners_;            // kNone: gone
  std::vector<std::vector<Index>> fan_;     // the triangles at each vertex
  std::vector<std::vector<Vec3>> samples_;  // of the given surface, at their nearest triangles
};

}  // namespace

TriMesh coarsen_surface(const TriMesh& surface, double edge, double tolerance, const Context& ctx) {
  return Coarsener(surface, edge, tolerance, ctx).run();
}

}  // namespace s3
