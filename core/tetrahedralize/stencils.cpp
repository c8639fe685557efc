// Labelle and Shewchuk 2007, "Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral
// Angles", Sec. 3. Diagonals of cut faces: they meet the cut of the long edge.
#include "tetrahedralize/stencils.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "tetrahedralize/boundary_check.h"

namespace s3 {

namespace {

// A vertex moves onto a cut within this share of the edge (the paper's α for safe dihedral angles).
constexpr double kWarpLong = 0.24999;
constexpr double kWarpShort = 0.41189;
// A vertex that must not move keeps its cuts at least this share of the edge away.
constexpr double kKeepAway = 0.3;

// Symmetric shapes are full of ties, which rounding decides differently on every platform: lengths
// are compared coarsely, and equal ones are told apart by their numbers.
constexpr double kCoarse = 1e-7;
long coarse(double x) {
  return std::lround(x / kCoarse);
}
bool is_shorter(double square, double than) {
  return square < (1 - kCoarse) * than;
}

enum class Side : signed char { outside = -1, border = 0, inside = 1 };

class Stuffing {
 public:
  Stuffing(const BccLattice& lattice, const std::vector<signed char>& winding,
           const std::vector<LatticeCut>& cuts)
      : lattice_(lattice),
        given_(cuts),
        frozen_(winding.size(), 0),
        winding_(winding),
        vertex_of_(winding.size(), -1) {
    std::sort(given_.begin(), given_.end(), [](const LatticeCut& a, const LatticeCut& b) {
      return std::tie(a.inner, a.outer) < std::tie(b.inner, b.outer);
    });
    for (std::size_t c = 0; c < given_.size(); ++c) {
      ends_.push_back({given_[c].inner, static_cast<Index>(c)});
      ends_.push_back({given_[c].outer, static_cast<Index>(c)});
    }
    std::sort(ends_.begin(), ends_.end());
  }

  TetMesh run(Context& ctx) {
    for (;;) {
      ctx.checkpoint();
      warp();
      fill();
      if (tets_.empty()) return {};
      TetMesh mesh = take_mesh();
      const std::vector<Index> bad = nonmanifold_boundary_vertices(mesh);
      if (bad.empty() || !freeze(bad)) return mesh;
    }
  }

 private:
  struct End {
    Index vertex, cut;
    bool operator<(const End& o) const { return std::tie(vertex, cut) < std::tie(o.vertex, o.cut); }
  };
  using Range = std::pair<std::vector<End>::const_iterator, std::vector<End>::const_iterator>;

  Range cuts_at(Index v) const {
    return std::equal_range(ends_.begin(), ends_.end(), End{v, 0},
                            [](const End& a, const End& b) { return a.vertex < b.vertex; });
  }

  // Moves each vertex with a near cut onto the nearest one, the nearest pairs first.
  void warp() {
    cuts_ = given_;
    alive_.assign(cuts_.size(), 1);
    side_.resize(winding_.size());
    for (std::size_t v = 0; v < winding_.size(); ++v)
      side_[v] = winding_[v] > 0 ? Side::inside : Side::outside;
    moved_.clear();

    std::vector<std::tuple<long, Index, Index>> candidates;
    for (std::size_t c = 0; c < cuts_.size(); ++c) {
      LatticeCut& cut = cuts_[c];
      keep_away_from_frozen(cut);
      const double limit = BccLattice::is_long(cut.inner, cut.outer) ? kWarpLong : kWarpShort;
      const auto offer = [&](Index v, double share) {
        if (share < limit && !frozen_[static_cast<std::size_t>(v)])
          candidates.emplace_back(coarse(share / limit), v, static_cast<Index>(c));
      };
      offer(cut.inner, cut.t);
      offer(cut.outer, 1 - cut.t);
    }
    std::sort(candidates.begin(), candidates.end());
    for (const auto& [distance, v, c] : candidates) {
      if (!alive_[static_cast<std::size_t>(c)]) continue;
      side_[static_cast<std::size_t>(v)] = Side::border;
      moved_.emplace_back(v, cuts_[static_cast<std::size_t>(c)].point);
      const Range range = cuts_at(v);
      for (auto it = range.first; it != range.second; ++it)
        alive_[static_cast<std::size_t>(it->cut)] = 0;
    }
    std::sort(moved_.begin(), moved_.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
  }

  void keep_away_from_frozen(LatticeCut& cut) const {
    const double low = frozen_[static_cast<std::size_t>(cut.inner)] ? kKeepAway : 0;
    const double high = frozen_[static_cast<std::size_t>(cut.outer)] ? 1 - kKeepAway : 1;
    if (cut.t >= low && cut.t <= high) return;
    cut.t = std::clamp(cut.t, low, high);
    const Vec3 inner = lattice_.position(cut.inner);
    cut.point = inner + cut.t * (lattice_.position(cut.outer) - inner);
  }

  void fill() {
    points_.clear();
    tets_.clear();
    source_.clear();
    std::fill(vertex_of_.begin(), vertex_of_.end(), -1);
    cut_vertex_.assign(cuts_.size(), -1);
    std::array<std::array<Index, 4>, 12> tets;
    for (Index center = 1; center < lattice_.count(); center += 2) {
      const int n = lattice_.own_tets(center, tets);
      for (int i = 0; i < n; ++i) fill_tet(tets[static_cast<std::size_t>(i)]);
    }
  }

  void fill_tet(const std::array<Index, 4>& corners) {
    std::array<Index, 4> plus, zero, minus;
    std::size_t p = 0, z = 0, m = 0;
    for (const Index v : corners) switch (side_[static_cast<std::size_t>(v)]) {
        case Side::inside:
          plus[p++] = v;
          break;
        case Side::border:
          zero[z++] = v;
          break;
        case Side::outside:
          minus[m++] = v;
          break;
      }
    if (p == 0) return;
    if (m == 0) {
      add(at(corners[0]), at(corners[1]), at(corners[2]), at(corners[3]));
    } else if (p == 1) {
      std::array<Index, 3> others;
      for (std::size_t i = 0; i < z; ++i) others[i] = at(zero[i]);
      for (std::size_t i = 0; i < m; ++i) others[z + i] = cut(plus[0], minus[i]);
      add(at(plus[0]), others[0], others[1], others[2]);
    } else if (p == 2 && m == 1) {
      add_pyramid(at(zero[0]), plus[0], plus[1], minus[0]);
    } else if (p == 2) {
      add_wedge(plus[0], plus[1], minus[0], minus[1]);
    } else {
      add_prism({at(plus[0]), at(plus[1]), at(plus[2])},
                {cut(plus[0], minus[0]), cut(plus[1], minus[0]), cut(plus[2], minus[0])},
                {from_first(plus[0], plus[1], minus[0]), from_first(plus[1], plus[2], minus[0]),
                 from_first(plus[2], plus[0], minus[0])});
    }
  }

  // Base p, q and their cuts towards m.
  void add_pyramid(Index apex, Index p, Index q, Index m) {
    const Index vp = at(p), vq = at(q), cp = cut(p, m), cq = cut(q, m);
    if (from_first(p, q, m)) {
      add(apex, vp, vq, cq);
      add(apex, vp, cq, cp);
    } else {
      add(apex, vq, cp, vp);
      add(apex, vq, cq, cp);
    }
  }

  // Two vertices inside, two outside: a prism between p with its cuts and q with its cuts. The
  // boundary's quad takes its shorter diagonal unless the prism has no tets with it.
  void add_wedge(Index p, Index q, Index m, Index n) {
    const std::array<Index, 3> first{at(p), cut(p, m), cut(p, n)},
        second{at(q), cut(q, m), cut(q, n)};
    const bool to_m = from_first(p, q, m), to_n = from_first(p, q, n);
    const double across = (point(first[1]) - point(second[2])).squaredNorm(),
                 back = (point(second[1]) - point(first[2])).squaredNorm();
    bool between = is_shorter(across, back);
    // A cycle: every lateral edge has one diagonal at each end.
    if (to_m == between && between == !to_n) between = !between;
    add_prism(first, second, {to_m, between, !to_n});
  }

  // The diagonal of side (i, i+1) runs from a_i to b_(i+1) where from_a[i], else from a_(i+1) to
  // b_i; not all three alike.
  void add_prism(const std::array<Index, 3>& a, const std::array<Index, 3>& b,
                 const std::array<bool, 3>& from_a) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      // Both diagonals beside edge i leave from a_i: from_a[i], and side (k, i) not from a_k.
      if (!from_a[i] || from_a[k]) continue;
      // The third side has a_j–b_k or a_k–b_j.
      const std::size_t near = from_a[j] ? j : k, far = from_a[j] ? k : j;
      add(a[0], a[1], a[2], b[far]);
      add(a[i], a[near], b[near], b[far]);
      add(a[i], b[0], b[1], b[2]);
      return;
    }
  }

  // Of the quad p, q and their cuts towards m, on a face that two tets share: whether the diagonal
  // leaves from p. It meets the cut of the long edge; between two short ones it is the shorter one.
  bool from_first(Index p, Index q, Index m) {
    if (BccLattice::is_long(p, m)) return false;
    if (BccLattice::is_long(q, m)) return true;
    const double from_p = (point(at(p)) - point(cut(q, m))).squaredNorm(),
                 from_q = (point(at(q)) - point(cut(p, m))).squaredNorm();
    if (is_shorter(from_p, from_q)) return true;
    return !is_shorter(from_q, from_p) && p < q;
  }

  void add(Index a, Index b, Index c, Index d) { tets_.push_back({a, b, c, d}); }

  const Vec3& point(Index vertex) const { return points_[static_cast<std::size_t>(vertex)]; }

  // The vertex of the result for a lattice vertex.
  Index at(Index v) {
    Index& vertex = vertex_of_[static_cast<std::size_t>(v)];
    if (vertex >= 0) return vertex;
    vertex = static_cast<Index>(points_.size());
    if (side_[static_cast<std::size_t>(v)] == Side::border) {
      const auto it = std::lower_bound(moved_.begin(), moved_.end(), v,
                                       [](const auto& a, Index id) { return a.first < id; });
      points_.push_back(it->second);
      source_.push_back(v);
    } else {
      points_.push_back(lattice_.position(v));
      source_.push_back(-1);
    }
    return vertex;
  }

  // The vertex of the result for a cut.
  Index cut(Index inner, Index outer) {
    const auto it = std::lower_bound(cuts_.begin(), cuts_.end(), std::pair(inner, outer),
                                     [](const LatticeCut& c, const std::pair<Index, Index>& key) {
                                       return std::pair(c.inner, c.outer) < key;
                                     });
    Index& vertex = cut_vertex_[static_cast<std::size_t>(it - cuts_.begin())];
    if (vertex >= 0) return vertex;
    vertex = static_cast<Index>(points_.size());
    points_.push_back(it->point);
    source_.push_back(-1);
    return vertex;
  }

  TetMesh take_mesh() const {
    Points vertices(static_cast<Eigen::Index>(points_.size()), 3);
    for (std::size_t v = 0; v < points_.size(); ++v)
      vertices.row(static_cast<Eigen::Index>(v)) = points_[v];
    Tets tets(static_cast<Eigen::Index>(tets_.size()), 4);
    for (std::size_t t = 0; t < tets_.size(); ++t)
      for (std::size_t i = 0; i < 4; ++i)
        tets(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(i)) = tets_[t][i];
    return make_tet_mesh(std::move(vertices), std::move(tets));
  }

  // Without moved vertices the stencils always give a manifold. @return false if nothing is left
  // to freeze
  bool freeze(const std::vector<Index>& vertices) {
    bool any = false;
    for (const Index v : vertices)
      if (const Index source = source_[static_cast<std::size_t>(v)]; source >= 0) {
        frozen_[static_cast<std::size_t>(source)] = 1;
        any = true;
      }
    return any;
  }

  const BccLattice& lattice_;
  std::vector<LatticeCut> given_;  // sorted by ends
  std::vector<End> ends_;          // the cuts at each vertex
  std::vector<char> frozen_;
  const std::vector<signed char>& winding_;

  std::vector<LatticeCut> cuts_;
  std::vector<char> alive_;
  std::vector<Side> side_;
  std::vector<std::pair<Index, Vec3>> moved_;  // sorted

  std::vector<Vec3> points_;
  std::vector<Index> source_;  // of each point: the moved lattice vertex, or −1
  std::vector<std::array<Index, 4>> tets_;
  std::vector<Index> vertex_of_, cut_vertex_;
};

}  // namespace

TetMesh stuff_lattice(const BccLattice& lattice, const std::vector<signed char>& winding,
                      const std::vector<LatticeCut>& cuts, Context& ctx) {
  return Stuffing(lattice, winding, cuts).run(ctx);
}

}  // namespace s3
