// Longest-edge bisection keeps angles bounded: Rivara 1984, "Algorithms for refining triangular
// grids suitable for adaptive and multigrid techniques". Flips in flat regions: Lawson 1977,
// "Software for C1 surface interpolation".
#include "mesh/refine_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <queue>
#include <vector>

#include "base/error.h"

namespace s3 {

namespace {

constexpr double kLongest =
    4.0 / 3;  // of the target: halves of longer edges are nearer to the target than the whole
constexpr double kFlatDistance = 1e-7;    // of the bounding box: single precision STL is no flatter
constexpr double kFlatCosine = 1 - 5e-5;  // normals within 0.01 rad
constexpr double kDelaunaySlack = 1e-9;   // four corners on one circle are left as they are
constexpr int kSmoothingRounds = 4;
constexpr double kMostTriangles = 2e7;
constexpr Index kNone = -1;

// Half-edge h = 3·f + i runs from corner i to corner i+1 of triangle f.
Index next(Index h) {
  return h % 3 == 2 ? h - 2 : h + 1;
}
Index previous(Index h) {
  return h % 3 == 0 ? h + 2 : h - 1;
}

class Refiner {
 public:
  Refiner(const TriMesh& mesh, double target_edge)
      : max_length2_(kLongest * target_edge * kLongest * target_edge),
        flat_distance_(kFlatDistance * bounding_box(mesh.vertices).diagonal()) {
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) points_.push_back(mesh.vertices.row(v));
    from_.assign(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
    find_opposites();
  }

  TriMesh refined() {
    const auto first_new = static_cast<Index>(points_.size());
    make_all_delaunay();
    split_long_edges();
    for (int round = 0; round < kSmoothingRounds; ++round) {
      smooth(first_new);
      make_all_delaunay();
    }
    split_long_edges();  // smoothing may have stretched one
    TriMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(points_.size()), 3);
    for (std::size_t v = 0; v < points_.size(); ++v)
      mesh.vertices.row(static_cast<Eigen::Index>(v)) = points_[v];
    mesh.triangles =
        Eigen::Map<const Triangles>(from_.data(), static_cast<Eigen::Index>(from_.size() / 3), 3);
    return mesh;
  }

 private:
  struct Long {
    double length2;
    Index half_edge;
    bool operator<(const Long& o) const {
      return length2 != o.length2 ? length2 < o.length2 : half_edge > o.half_edge;
    }
  };

  Index half_edges() const { return static_cast<Index>(from_.size()); }
  Index& from(Index h) { return from_[static_cast<std::size_t>(h)]; }
  Index& opposite(Index h) { return opposite_[static_cast<std::size_t>(h)]; }
  const Vec3& point(Index v) const { return points_[static_cast<std::size_t>(v)]; }
  double length2(Index h) { return (point(from(next(h))) - point(from(h))).squaredNorm(); }

  void find_opposites() {
    struct Side {
      Index low, high, half_edge;
      bool operator<(const Side& o) const {
        if (low != o.low) return low < o.low;
        return high != o.high ? high < o.high : half_edge < o.half_edge;
      }
    };
    std::vector<Side> sides;
    sides.reserve(from_.size());
    for (Index h = 0; h < half_edges(); ++h)
      sides.push_back({std::min(from(h), from(next(h))), std::max(from(h), from(next(h))), h});
    std::sort(sides.begin(), sides.end());
    opposite_.assign(from_.size(), kNone);
    const auto same = [&](std::size_t i, std::size_t j) {
      return j < sides.size() && sides[i].low == sides[j].low && sides[i].high == sides[j].high;
    };
    for (std::size_t i = 0; i < sides.size(); ++i) {
      if (!same(i, i + 1)) continue;
      const Index h = sides[i].half_edge, g = sides[i + 1].half_edge;
      if (same(i, i + 2) || from(h) == from(g))
        throw Error(ErrorKind::input, Stage::mesh, "mesh.non_manifold",
                    "The surface cannot be refined: triangles " + std::to_string(h / 3) + " and " +
                        std::to_string(g / 3) + " do not continue each other across their edge",
                    "Repair the surface first", {point(from(h))});
      opposite(h) = g;
      opposite(g) = h;
      ++i;
    }
  }

  void link(Index h, Index g) {
    opposite(h) = g;
    if (g != kNone) opposite(g) = h;
  }

  void set_corners(Index f, Index a, Index b, Index c) {
    from(3 * f) = a;
    from(3 * f + 1) = b;
    from(3 * f + 2) = c;
  }

  Index new_triangle() {
    if (from_.size() / 3 >= static_cast<std::size_t>(kMostTriangles))
      throw Error(
          ErrorKind::input, Stage::mesh, "mesh.too_fine",
          "The surface would need more than 20 million triangles for the asked element size",
          "Ask for fewer tets or a longer edge, or check the scale of the model");
    const Index f = half_edges() / 3;
    from_.resize(from_.size() + 3);
    opposite_.resize(opposite_.size() + 3, kNone);
    return f;
  }

  void queue_if_long(Index h) {
    if (opposite(h) != kNone && opposite(h) < h) h = opposite(h);
    const double l2 = length2(h);
    if (l2 > max_length2_) queue_.push({l2, h});
  }

  // Cuts the triangle of h in two at the new vertex m on h. @return the half-edge from m to the old
  // end of h
  Index split_side(Index h, Index m) {
    const Index f = h / 3, a = from(h), b = from(next(h)), c = from(previous(h));
    const Index bc = opposite(next(h)), ca = opposite(previous(h));
    const Index g = new_triangle();
    set_corners(f, a, m, c);
    set_corners(g, m, b, c);
    opposite(3 * f) = kNone;
    link(3 * f + 1, 3 * g + 2);
    link(3 * f + 2, ca);
    link(3 * g + 1, bc);
    return 3 * g;
  }

  void split(Index h) {
    const Index other = opposite(h);
    const auto m = static_cast<Index>(points_.size());
    points_.push_back(0.5 * (point(from(h)) + point(from(next(h)))));
    const Index f = h / 3;
    const Index g = split_side(h, m);  // f: 3f = a→m, g = m→b
    std::vector<Index> around = {3 * f + 1, 3 * f + 2, g + 1};
    std::vector<Index> changed = {3 * f, 3 * f + 1, 3 * f + 2, g, g + 1};
    if (other != kNone) {
      const Index o = other / 3;
      const Index p = split_side(other, m);  // o: 3o = b→m, p = m→a
      link(3 * f, p);
      link(g, 3 * o);
      around.insert(around.end(), {3 * o + 1, 3 * o + 2, p + 1});
      changed.insert(changed.end(), {3 * o + 1, 3 * o + 2, p + 1});
    }
    for (const Index c : changed) queue_if_long(c);
    flips_left_ += 20;
    make_delaunay(std::move(around));
  }

  void make_all_delaunay() {
    std::vector<Index> all(from_.size());
    std::iota(all.begin(), all.end(), 0);
    flips_left_ = 20 * all.size();
    make_delaunay(std::move(all));
  }

  void split_long_edges() {
    queue_ = {};
    for (Index h = 0; h < half_edges(); ++h) queue_if_long(h);
    while (!queue_.empty()) {
      const Long top = queue_.top();
      queue_.pop();
      // An edge that was split or flipped meanwhile has queued its successors itself.
      if (length2(top.half_edge) == top.length2) split(top.half_edge);
    }
  }

  // Area over squared edges of the triangle of h with its first corner at p; negative when it faces
  // away from `normal`.
  double shape(Index h, const Vec3& p, const Vec3& normal) {
    const Vec3 &b = point(from(next(h))), &c = point(from(previous(h)));
    return (b - p).cross(c - p).dot(normal) /
           ((b - p).squaredNorm() + (c - p).squaredNorm() + (c - b).squaredNorm());
  }

  // The half-edges that leave the vertex of h when all triangles around it lie in one plane;
  // otherwise empty.
  void flat_fan(Index h, Vec3& normal, std::vector<Index>& fan) {
    fan.clear();
    normal.setZero();
    const Vec3& center = point(from(h));
    for (Index at = h;;) {
      fan.push_back(at);
      normal += (point(from(next(at))) - center).cross(point(from(previous(at))) - center);
      at = opposite(previous(at));
      if (at == kNone) return fan.clear();
      if (at == h) break;
    }
    normal.normalize();
    for (const Index at : fan) {
      const Vec3 u = point(from(next(at))) - center, v = point(from(previous(at))) - center;
      const Vec3 n = u.cross(v);
      if (!(n.dot(normal) >= kFlatCosine * n.norm()) ||
          !(std::abs(u.dot(normal)) <= flat_distance_))
        return fan.clear();
    }
  }

  // Moves new vertices within flat regions to the middle of their neighbours where that improves
  // the worst triangle.
  void smooth(Index first_new) {
    std::vector<Index> leaving(points_.size(), kNone);
    for (Index h = 0; h < half_edges(); ++h) leaving[static_cast<std::size_t>(from(h))] = h;
    std::vector<Index> fan;
    Vec3 normal;
    for (auto v = static_cast<std::size_t>(first_new); v < points_.size(); ++v) {
      flat_fan(leaving[v], normal, fan);
      if (fan.empty()) continue;
      Vec3 step = Vec3::Zero();
      for (const Index h : fan) step += point(from(next(h))) - points_[v];
      step /= static_cast<double>(fan.size());
      const Vec3 moved = points_[v] + (step - step.dot(normal) * normal);
      double before = 1, after = 1;
      for (const Index h : fan) {
        before = std::min(before, shape(h, points_[v], normal));
        after = std::min(after, shape(h, moved, normal));
      }
      if (after > before) points_[v] = moved;
    }
  }

  // Cotangent of the angle at the corner that h does not touch.
  double opposite_cotangent(Index h) {
    const Vec3& tip = point(from(previous(h)));
    const Vec3 u = point(from(h)) - tip, v = point(from(next(h))) - tip;
    const double area2 = u.cross(v).norm();
    return area2 > 0 ? u.dot(v) / area2 : (u.dot(v) > 0 ? 1e300 : -1e300);
  }

  // The four corners lie in one plane, and the flipped triangles face the same way.
  bool may_flip(Index h) {
    const Index g = opposite(h);
    const Index a = from(h), b = from(next(h)), c = from(previous(h)), d = from(previous(g));
    if (c == d) return false;
    const Vec3 pa = point(a), pb = point(b), pc = point(c), pd = point(d);
    const Vec3 n1 = (pb - pa).cross(pc - pa), n2 = (pa - pb).cross(pd - pb);
    const Vec3 sum = n1 + n2;
    const double length = sum.norm();
    if (!(length > 0)) return false;
    const Vec3 normal = sum / length;
    const double height = normal.dot(pa);
    for (const Vec3* p : {&pb, &pc, &pd})
      if (std::abs(normal.dot(*p) - height) > flat_distance_) return false;
    const auto faces_alike = [&](const Vec3& n) { return n.dot(normal) >= kFlatCosine * n.norm(); };
    const Vec3 m1 = (pd - pa).cross(pc - pa), m2 = (pb - pd).cross(pc - pd);
    const double least =
        1e-12 * length;  // a corner on the new edge would leave a triangle without area
    return faces_alike(n1) && faces_alike(n2) && m1.norm() > least && m2.norm() > least &&
           faces_alike(m1) && faces_alike(m2) && !tip_sees(h, d);
  }

  // On thin closed parts, the other diagonal may be an edge already. Walks around the corner that h
  // does not touch.
  bool tip_sees(Index h, Index vertex) {
    const Index start = previous(h);  // leaves the tip
    Index at = start;
    do {
      if (from(next(at)) == vertex || from(previous(at)) == vertex) return true;
      at = opposite(previous(at));
    } while (at != kNone && at != start);
    return false;
  }

  void flip(Index h) {
    const Index g = opposite(h), f1 = h / 3, f2 = g / 3;
    const Index a = from(h), b = from(next(h)), c = from(previous(h)), d = from(previous(g));
    const Index bc = opposite(next(h)), ca = opposite(previous(h)), ad = opposite(next(g)),
                db = opposite(previous(g));
    set_corners(f1, a, d, c);
    set_corners(f2, d, b, c);
    link(3 * f1, ad);
    link(3 * f1 + 1, 3 * f2 + 2);
    link(3 * f1 + 2, ca);
    link(3 * f2, db);
    link(3 * f2 + 1, bc);
  }

  void make_delaunay(std::vector<Index> stack) {
    while (!stack.empty()) {
      const Index h = stack.back();
      stack.pop_back();
      if (opposite(h) == kNone || flips_left_ == 0) continue;
      if (opposite_cotangent(h) + opposite_cotangent(opposite(h)) >= -kDelaunaySlack ||
          !may_flip(h))
        continue;
      const Index f1 = h / 3, f2 = opposite(h) / 3;
      flip(h);
      --flips_left_;
      for (const Index outer : {3 * f1, 3 * f1 + 2, 3 * f2, 3 * f2 + 1}) {
        stack.push_back(outer);
        queue_if_long(outer);  // its number changed
      }
      queue_if_long(3 * f1 + 1);
    }
  }

  double max_length2_, flat_distance_;
  std::size_t flips_left_ = 0;  // against cycles by rounding
  std::vector<Vec3> points_;
  std::vector<Index> from_, opposite_;
  std::priority_queue<Long> queue_;
};

}  // namespace

TriMesh refine_surface(const TriMesh& mesh, double target_edge) {
  // Even triangles of the target's size have an area of √3/4 · edge².
  if (!(target_edge > 0) ||
      surface_area(mesh) / (0.433 * target_edge * target_edge) > kMostTriangles)
    throw Error(
        ErrorKind::input, Stage::mesh, "mesh.too_fine",
        "An element size of " + std::to_string(target_edge) + " mm is too small for this surface",
        "Ask for fewer tets or a longer edge, or check the scale of the model");
  return Refiner(mesh, target_edge).refined();
}

double target_edge_for(const TriMesh& mesh, int target_tets) {
  const double volume = enclosed_volume(mesh);
  if (!(volume > 0))
    throw Error(ErrorKind::input, Stage::mesh, "mesh.inverted",
                "The surface encloses no volume (" + std::to_string(volume) + " mm³)",
                "Close the surface and let its triangles face outward");
  return std::cbrt(6 * std::sqrt(2.0) * volume / std::max(target_tets, 1));
}

}  // namespace s3
