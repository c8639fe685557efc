#include "mesh/fill_polygon.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "mesh/exact_predicates.h"

namespace s3 {

namespace {

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

// Exact tests in the coordinate plane that the polygon is seen in.
class Plane {
 public:
  Plane(const Points& points, const Vec3& normal) : points_(points) {
    normal.cwiseAbs().maxCoeff(&drop_);
    flip_ = normal[drop_] < 0;
  }

  Vec3 point(Index v) const { return points_.row(v); }
  double x(Index v) const { return points_(v, (drop_ + 1) % 3); }
  double y(Index v) const { return points_(v, (drop_ + 2) % 3); }

  // +1 where a, b, c turn left as seen against the normal.
  int turn(Index a, Index b, Index c) const {
    const int sign = orient2d(point(a), point(b), point(c), drop_);
    return flip_ ? -sign : sign;
  }
  bool in_closed_triangle(Index p, Index a, Index b, Index c) const {
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
  }
  // The open segments cross, or an end of one lies within the other.
  bool cross(Index a, Index b, Index c, Index d) const {
    const int c_side = turn(a, b, c), d_side = turn(a, b, d), a_side = turn(c, d, a),
              b_side = turn(c, d, b);
    if (c_side * d_side < 0 && a_side * b_side < 0) return true;
    const auto within = [&](int side, Index p, Index u, Index v) {
      return side == 0 && p != u && p != v && between(p, u, v);
    };
    return within(c_side, c, a, b) || within(d_side, d, a, b) || within(a_side, a, c, d) ||
           within(b_side, b, c, d);
  }

 private:
  bool between(Index p, Index u, Index v) const {
    return std::min(x(u), x(v)) <= x(p) && x(p) <= std::max(x(u), x(v)) &&
           std::min(y(u), y(v)) <= y(p) && y(p) <= std::max(y(u), y(v));
  }

  const Points& points_;
  int drop_ = 2;
  bool flip_ = false;
};

// Nodes of the polygon by place, in square cells.
class Cells {
 public:
  Cells(const Plane& plane, const std::vector<Index>& vertices) {
    low_x_ = low_y_ = 1e300;
    double high_x = -1e300, high_y = -1e300;
    for (const Index v : vertices) {
      low_x_ = std::min(low_x_, plane.x(v)), high_x = std::max(high_x, plane.x(v));
      low_y_ = std::min(low_y_, plane.y(v)), high_y = std::max(high_y, plane.y(v));
    }
    const double side = std::max({high_x - low_x_, high_y - low_y_, 1e-300});
    n_ = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(vertices.size()))), 1, 1024);
    scale_ = n_ / side;
    cells_.resize(static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_));
  }

  void add(const Plane& plane, Index vertex, Index node) {
    cells_[cell(column(plane.x(vertex)), row(plane.y(vertex)))].push_back(node);
  }

  // True when test(node) holds for some node in the cells of a box.
  template <class Test>
  bool any_in_box(double x0, double x1, double y0, double y1, Test&& test) const {
    for (int j = row(y0); j <= row(y1); ++j)
      for (int i = column(x0); i <= column(x1); ++i)
        for (const Index node : cells_[cell(i, j)])
          if (test(node)) return true;
    return false;
  }

 private:
  int column(double x) const { return index((x - low_x_) * scale_); }
  int row(double y) const { return index((y - low_y_) * scale_); }
  int index(double t) const { return std::clamp(static_cast<int>(t), 0, n_ - 1); }
  std::size_t cell(int i, int j) const { return static_cast<std::size_t>(j * n_ + i); }

  double low_x_, low_y_, scale_ = 1;
  int n_ = 1;
  std::vector<std::vector<Index>> cells_;
};

// Joins holes with the outer loop: the polygon then runs along each bridge twice.
class Bridges {
 public:
  Bridges(const Plane& plane, const std::vector<std::vector<Index>>& loops)
      : plane_(plane), outline_(loops[0]) {
    for (const auto& loop : loops)
      for (std::size_t i = 0; i < loop.size(); ++i)
        edges_.push_back({loop[i], loop[(i + 1) % loop.size()]});
    holes_.assign(loops.begin() + 1, loops.end());
    // From one side to the other, so that a hole finds the outline or an earlier hole in its way.
    std::sort(holes_.begin(), holes_.end(), [&](const auto& a, const auto& b) {
      const Index va = a[at(leftmost(a))], vb = b[at(leftmost(b))];
      return plane.x(va) != plane.x(vb) ? plane.x(va) < plane.x(vb) : va < vb;
    });
  }

  // Empty when some hole cannot be reached.
  std::vector<Index> outline() {
    for (const auto& hole : holes_)
      if (!join(hole)) return {};
    return outline_;
  }

 private:
  Index leftmost(const std::vector<Index>& loop) const {
    const auto it = std::min_element(loop.begin(), loop.end(), [&](Index a, Index b) {
      return plane_.x(a) != plane_.x(b) ? plane_.x(a) < plane_.x(b) : plane_.y(a) < plane_.y(b);
    });
    return static_cast<Index>(it - loop.begin());
  }

  bool join(const std::vector<Index>& hole) {
    const Index start = leftmost(hole), h = hole[at(start)];
    std::vector<std::pair<double, Index>> nearest;  // squared distance, position in the outline
    for (std::size_t i = 0; i < outline_.size(); ++i)
      nearest.emplace_back((plane_.point(outline_[i]) - plane_.point(h)).squaredNorm(),
                           static_cast<Index>(i));
    std::sort(nearest.begin(), nearest.end());
    for (const auto& [distance, i] : nearest) {
      if (!in_wedge(i, h) || crosses(outline_[at(i)], h)) continue;
      splice(i, hole, start);
      edges_.push_back({outline_[at(i)], h});
      return true;
    }
    return false;
  }

  // The bridge leaves the outline to its inside, even where several bridges meet.
  bool in_wedge(Index i, Index h) const {
    const std::size_t n = outline_.size();
    const Index before = outline_[(at(i) + n - 1) % n], v = outline_[at(i)],
                after = outline_[(at(i) + 1) % n];
    const int left = plane_.turn(v, after, h), right = plane_.turn(before, v, h);
    return plane_.turn(before, v, after) > 0 ? left > 0 && right > 0 : left > 0 || right > 0;
  }

  bool crosses(Index a, Index b) const {
    return std::any_of(edges_.begin(), edges_.end(),
                       [&](const auto& e) { return plane_.cross(a, b, e[0], e[1]); });
  }

  void splice(Index i, const std::vector<Index>& hole, Index start) {
    std::vector<Index> detour;
    for (std::size_t k = 0; k <= hole.size(); ++k)
      detour.push_back(hole[(at(start) + k) % hole.size()]);
    detour.push_back(outline_[at(i)]);
    outline_.insert(outline_.begin() + i + 1, detour.begin(), detour.end());
  }

  const Plane& plane_;
  std::vector<Index> outline_;
  std::vector<std::vector<Index>> holes_;
  std::vector<std::array<Index, 2>> edges_;
};

class EarClipper {
 public:
  EarClipper(const Plane& plane, std::vector<Index> outline)
      : plane_(plane),
        vertex_(std::move(outline)),
        cells_(plane, vertex_),
        next_(vertex_.size()),
        previous_(vertex_.size()),
        age_(vertex_.size(), 0) {
    const auto n = static_cast<Index>(vertex_.size());
    for (Index i = 0; i < n; ++i) {
      next_[at(i)] = (i + 1) % n;
      previous_[at((i + 1) % n)] = i;
    }
    // A corner that turns left now turns left for good: only the others can stand in an ear's way.
    for (Index i = 0; i < n; ++i)
      if (turn(i) <= 0) cells_.add(plane_, vertex_[at(i)], i);
  }

  std::vector<std::array<Index, 3>> clipped() {
    auto left = static_cast<Index>(vertex_.size());
    std::vector<std::array<Index, 3>> triangles;
    for (Index i = 0; i < left; ++i) consider(i);
    std::size_t last_scan = vertex_.size() + 1;
    while (left > 3) {
      if (ears_.empty()) {  // what stood in the way may have gone
        if (static_cast<std::size_t>(left) >= last_scan) return {};
        last_scan = static_cast<std::size_t>(left);
        scan();
        if (ears_.empty()) return {};
      }
      const Ear ear = ears_.top();
      ears_.pop();
      if (age_[at(ear.node)] != ear.age) continue;
      const Index before = previous_[at(ear.node)], after = next_[at(ear.node)];
      triangles.push_back({vertex_[at(before)], vertex_[at(ear.node)], vertex_[at(after)]});
      next_[at(before)] = after;
      previous_[at(after)] = before;
      age_[at(ear.node)] = -1;
      first_ = after;
      --left;
      for (const Index node : {before, after}) {
        ++age_[at(node)];
        consider(node);
      }
    }
    const Index last = first_ < 0 ? 0 : first_;
    if (turn(last) <= 0) return {};
    triangles.push_back(
        {vertex_[at(previous_[at(last)])], vertex_[at(last)], vertex_[at(next_[at(last)])]});
    return triangles;
  }

 private:
  struct Ear {
    double quality;
    Index node, age;
    bool operator<(const Ear& o) const {
      return quality != o.quality ? quality < o.quality : node > o.node;
    }
  };

  int turn(Index i) const {
    return plane_.turn(vertex_[at(previous_[at(i)])], vertex_[at(i)], vertex_[at(next_[at(i)])]);
  }

  bool is_ear(Index i) const {
    if (turn(i) <= 0) return false;
    const Index a = vertex_[at(previous_[at(i)])], b = vertex_[at(i)],
                c = vertex_[at(next_[at(i)])];
    const double x0 = std::min({plane_.x(a), plane_.x(b), plane_.x(c)}),
                 x1 = std::max({plane_.x(a), plane_.x(b), plane_.x(c)}),
                 y0 = std::min({plane_.y(a), plane_.y(b), plane_.y(c)}),
                 y1 = std::max({plane_.y(a), plane_.y(b), plane_.y(c)});
    return !cells_.any_in_box(x0, x1, y0, y1, [&](Index node) {
      const Index p = vertex_[at(node)];
      return age_[at(node)] >= 0 && p != a && p != b && p != c && turn(node) <= 0 &&
             plane_.in_closed_triangle(p, a, b, c);
    });
  }

  // Area over squared edges: 1/(4√3) for an even triangle.
  double quality(Index i) const {
    const Vec3 a = plane_.point(vertex_[at(previous_[at(i)])]), b = plane_.point(vertex_[at(i)]),
               c = plane_.point(vertex_[at(next_[at(i)])]);
    return (b - a).cross(c - a).norm() /
           ((b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm());
  }

  void consider(Index i) {
    if (is_ear(i)) ears_.push({quality(i), i, age_[at(i)]});
  }

  void scan() {
    const Index start = first_ < 0 ? 0 : first_;
    Index i = start;
    do {
      consider(i);
      i = next_[at(i)];
    } while (i != start);
  }

  const Plane& plane_;
  std::vector<Index> vertex_;  // of each node; bridges have two nodes at a vertex
  Cells cells_;
  std::vector<Index> next_, previous_;
  std::vector<Index> age_;  // counts the changes of a node's ear; −1: clipped
  Index first_ = -1;
  std::priority_queue<Ear> ears_;
};

}  // namespace

std::vector<std::array<Index, 3>> fill_polygon(const Points& points,
                                               const std::vector<std::vector<Index>>& loops,
                                               const Vec3& normal) {
  if (loops.empty() || loops[0].size() < 3) return {};
  const Plane plane(points, normal);
  std::vector<Index> outline = Bridges(plane, loops).outline();
  if (outline.size() < 3) return {};
  return EarClipper(plane, std::move(outline)).clipped();
}

}  // namespace s3
