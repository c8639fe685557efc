// Surface-area heuristic in bins: Wald 2007, "On fast Construction of SAH-based Bounding Volume
// Hierarchies". Closest point on a triangle: Ericson 2005, "Real-Time Collision Detection",
// Sec. 5.1.5. Ray and triangle: Möller and Trumbore 1997.
#include "mesh/aabb_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace s3 {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kLeafSize = 4;
constexpr int kBins = 16;
constexpr Index kUnused = -1;  // count of a slot without faces
// Below this depth the tree halves by count, so that it ends within 16 more levels of four: the
// stacks below suffice.
constexpr int kDepthOfHalving = 28;
constexpr int kStackSize = 3 * (kDepthOfHalving + 17) + 1;
// A triangle counts as flat when its area is below the rounding error of the cross product.
constexpr double kFlat = 1e-14;

struct Bounds {
  Eigen::Array3d low = Eigen::Array3d::Constant(kInfinity);
  Eigen::Array3d high = Eigen::Array3d::Constant(-kInfinity);

  void add(const Bounds& o) {
    low = low.min(o.low);
    high = high.max(o.high);
  }
  double half_area() const {
    const Eigen::Array3d size = high - low;
    if (!(size[0] >= 0)) return 0;
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
  }
};

float rounded_down(double x) {
  const float f = static_cast<float>(x);
  return f > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

float rounded_up(double x) {
  const float f = static_cast<float>(x);
  return f < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

// Barycentric weights of the closest point in a segment a + s·d, |d| ≥ 0.
double clamp_to_segment(const Vec3& from_a, const Vec3& d) {
  const double length2 = d.squaredNorm();
  return length2 > 0 ? std::clamp(from_a.dot(d) / length2, 0.0, 1.0) : 0.0;
}

struct Weights {
  double v, w;  // point = a + v·ab + w·ac
};

Weights closest_weights_of_flat(const Vec3& ap, const Vec3& ab, const Vec3& ac) {
  const Vec3 bc = ac - ab;
  const double s = clamp_to_segment(ap, ab), t = clamp_to_segment(ap, ac),
               u = clamp_to_segment(ap - ab, bc);
  const double d_ab = (ap - s * ab).squaredNorm(), d_ac = (ap - t * ac).squaredNorm(),
               d_bc = (ap - ab - u * bc).squaredNorm();
  if (d_ab <= d_ac && d_ab <= d_bc) return {s, 0};
  return d_ac <= d_bc ? Weights{0, t} : Weights{1 - u, u};
}

Weights closest_weights(const Vec3& ap, const Vec3& ab, const Vec3& ac) {
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  const double ab2 = ab.squaredNorm(), ac2 = ac.squaredNorm(), cross = ab.dot(ac);
  const double d3 = d1 - ab2, d4 = d2 - cross;  // ab·bp, ac·bp
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {d1 / ab2, 0};
  const double d5 = d1 - cross, d6 = d2 - ac2;  // ab·cp, ac·cp
  if (d6 >= 0 && d5 <= d6) return {0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {0, d2 / ac2};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {1 - w, w};
  }
  const double scale = 1 / (va + vb + vc);
  return {vb * scale, vc * scale};
}

bool is_flat(const Vec3& ab, const Vec3& ac) {
  const double longest2 = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  return !(ab.cross(ac).norm() > kFlat * longest2);
}

// t of the hit, infinity for none.
double ray_triangle(const Vec3& origin, const Vec3& direction, const Vec3& a, const Vec3& ab,
                    const Vec3& ac) {
  constexpr double kSlack =
      1e-12;  // in barycentric weights: neighbours overlap by it instead of leaving a gap
  const Vec3 h = direction.cross(ac);
  const double det = ab.dot(h);
  if (det == 0) return kInfinity;
  const Vec3 from_a = origin - a;
  const double u = from_a.dot(h) / det;
  if (!(u >= -kSlack && u <= 1 + kSlack)) return kInfinity;
  const Vec3 q = from_a.cross(ab);
  const double v = direction.dot(q) / det;
  if (!(v >= -kSlack && u + v <= 1 + kSlack)) return kInfinity;
  return ac.dot(q) / det;
}

}  // namespace

Closest closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ap = p - a, ab = b - a, ac = c - a;
  const auto [v, w] =
      is_flat(ab, ac) ? closest_weights_of_flat(ap, ab, ac) : closest_weights(ap, ab, ac);
  Closest result;
  result.point = a + v * ab + w * ac;
  result.distance = (ap - v * ab - w * ac).norm();
  result.triangle = 0;
  result.barycentric = Vec3(1 - v - w, v, w);
  return result;
}

struct AabbTree::BuildItem {
  Bounds bounds;
  Index triangle;
  Eigen::Array3d center() const { return 0.5 * (bounds.low + bounds.high); }
};

namespace {

// Sorts items[begin, end) into two parts of the least surface-area cost. @return where the second
// begins
template <class Items>
std::size_t split(Items& items, std::size_t begin, std::size_t end, bool halve) {
  Bounds centers;
  for (std::size_t i = begin; i < end; ++i) {
    const Eigen::Array3d c = items[i].center();
    centers.add({c, c});
  }
  const Eigen::Array3d extent = centers.high - centers.low;
  int axis;
  extent.maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto by_count = [&] {
    std::nth_element(items.begin() + begin, items.begin() + middle, items.begin() + end,
                     [axis](const auto& a, const auto& b) {
                       const double ca = a.center()[axis], cb = b.center()[axis];
                       return ca != cb ? ca < cb : a.triangle < b.triangle;
                     });
    return middle;
  };
  // Not finite where the centers lie in one place, or closer than numbers can divide.
  const double scale = kBins / extent[axis];
  if (halve || !std::isfinite(scale) || end - begin <= 2 * kLeafSize) return by_count();

  std::array<Bounds, kBins> bin_bounds;
  std::array<std::size_t, kBins> bin_count{};
  const double low = centers.low[axis];
  const auto bin_of = [&](const auto& item) {
    return std::clamp(static_cast<int>((item.center()[axis] - low) * scale), 0, kBins - 1);
  };
  for (std::size_t i = begin; i < end; ++i) {
    const auto bin = static_cast<std::size_t>(bin_of(items[i]));
    bin_bounds[bin].add(items[i].bounds);
    ++bin_count[bin];
  }
  // cost(k): the bins below k on one side, the rest on the other.
  std::array<double, kBins> upper_cost{};
  Bounds side;
  std::size_t count = 0;
  for (int k = kBins - 1; k > 0; --k) {
    side.add(bin_bounds[static_cast<std::size_t>(k)]);
    count += bin_count[static_cast<std::size_t>(k)];
    upper_cost[static_cast<std::size_t>(k)] = side.half_area() * static_cast<double>(count);
  }
  side = {};
  count = 0;
  int best = 0;
  double best_cost = kInfinity;
  for (int k = 1; k < kBins; ++k) {
    side.add(bin_bounds[static_cast<std::size_t>(k - 1)]);
    count += bin_count[static_cast<std::size_t>(k - 1)];
    const double cost =
        side.half_area() * static_cast<double>(count) + upper_cost[static_cast<std::size_t>(k)];
    if (count > 0 && count < end - begin && cost < best_cost) {
      best = k;
      best_cost = cost;
    }
  }
  if (best == 0) return by_count();
  const auto second = std::partition(items.begin() + begin, items.begin() + end,
                                     [&](const auto& item) { return bin_of(item) < best; });
  return static_cast<std::size_t>(second - items.begin());
}

}  // namespace

AabbTree::AabbTree(const Points& vertices, const Triangles& triangles) {
  const auto n = static_cast<std::size_t>(triangles.rows());
  if (n == 0) return;
  std::vector<BuildItem> items(n);
  for (std::size_t f = 0; f < n; ++f) {
    items[f].triangle = static_cast<Index>(f);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Array3d p = vertices.row(triangles(static_cast<Eigen::Index>(f), i)).transpose();
      items[f].bounds.add({p, p});
    }
  }
  nodes_.reserve(n / 3 + 1);
  build(items, 0, n, 0);
  nodes_.shrink_to_fit();
  faces_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Index f = items[i].triangle;
    const Vec3 a = vertices.row(triangles(f, 0)), b = vertices.row(triangles(f, 1)),
               c = vertices.row(triangles(f, 2));
    faces_[i] = {a, b - a, c - a, f, is_flat(b - a, c - a)};
  }
}

Index AabbTree::build(std::vector<BuildItem>& items, std::size_t begin, std::size_t end,
                      int depth) {
  const auto index = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  // Two rounds of splits: [begin, c1) [c1, c2) [c2, c3) [c3, end).
  const bool halve = depth >= kDepthOfHalving;
  std::array<std::size_t, 5> cuts = {begin, end, end, end, end};
  if (end - begin > kLeafSize) {
    const std::size_t middle = split(items, begin, end, halve);
    cuts[2] = middle;
    cuts[1] = middle - begin > kLeafSize ? split(items, begin, middle, halve) : middle;
    cuts[3] = end - middle > kLeafSize ? split(items, middle, end, halve) : end;
  }
  for (std::size_t k = 0; k < 4; ++k) {
    Bounds bounds;
    for (std::size_t i = cuts[k]; i < cuts[k + 1]; ++i) bounds.add(items[i].bounds);
    const std::size_t count = cuts[k + 1] - cuts[k];
    const bool leaf = count <= kLeafSize;
    // Which triangle wins at equal distances must not depend on the library's nth_element.
    if (leaf)
      std::sort(items.begin() + static_cast<std::ptrdiff_t>(cuts[k]),
                items.begin() + static_cast<std::ptrdiff_t>(cuts[k + 1]),
                [](const BuildItem& a, const BuildItem& b) { return a.triangle < b.triangle; });
    const Index first =
        leaf ? static_cast<Index>(cuts[k]) : build(items, cuts[k], cuts[k + 1], depth + 1);
    Node& node = nodes_[static_cast<std::size_t>(index)];  // build() may have moved the nodes
    node.first[k] = first;
    node.count[k] = !leaf ? 0 : count > 0 ? static_cast<Index>(count) : kUnused;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.low[axis][k] = rounded_down(bounds.low[static_cast<Eigen::Index>(axis)]);
      node.high[axis][k] = rounded_up(bounds.high[static_cast<Eigen::Index>(axis)]);
    }
  }
  return index;
}

Closest AabbTree::closest(const Vec3& p, double max_distance) const {
  Closest result;
  if (faces_.empty() || !(max_distance >= 0)) return result;
  struct Entry {
    Index node;
    double distance2;
  };
  std::array<Entry, kStackSize> stack;
  int size = 0;
  stack[static_cast<std::size_t>(size++)] = {0, 0};
  double best2 = max_distance * max_distance;
  const Face* best_face = nullptr;
  Weights best{0, 0};

  const auto visit_leaf = [&](Index first, Index count) {
    for (Index i = first; i < first + count; ++i) {
      const Face& face = faces_[static_cast<std::size_t>(i)];
      const Vec3 ap = p - face.a;
      const Weights at = face.flat ? closest_weights_of_flat(ap, face.ab, face.ac)
                                   : closest_weights(ap, face.ab, face.ac);
      const double d2 = (ap - at.v * face.ab - at.w * face.ac).squaredNorm();
      if (d2 < best2 || (d2 == best2 && !best_face)) {
        best2 = d2;
        best = at;
        best_face = &face;
      }
    }
  };

  while (size > 0) {
    const Entry entry = stack[static_cast<std::size_t>(--size)];
    if (entry.distance2 > best2) continue;
    const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
    // Lower bounds for the four children at once; Eigen turns each line into one or two vector
    // instructions.
    using Four = Eigen::Array<double, 4, 1>;
    std::array<double, 4> d2;
    Four sum = Four::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = p[static_cast<Eigen::Index>(axis)];
      const float *low = node.low[axis], *high = node.high[axis];
      const Four below(low[0] - x, low[1] - x, low[2] - x, low[3] - x);
      const Four above(x - high[0], x - high[1], x - high[2], x - high[3]);
      sum += below.max(above).max(0.0).square();
    }
    Eigen::Map<Four>(d2.data()) = sum;
    // The children within reach, nearest first: usually one or two.
    std::array<std::size_t, 4> near;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (!(d2[k] <= best2)) continue;
      std::size_t at = count++;
      for (; at > 0 && d2[near[at - 1]] > d2[k]; --at) near[at] = near[at - 1];
      near[at] = k;
    }
    for (std::size_t i = 0; i < count; ++i)
      if (node.count[near[i]] > 0 && d2[near[i]] <= best2)
        visit_leaf(node.first[near[i]], node.count[near[i]]);
    // Farthest first, so that the nearest child is on top of the stack.
    for (std::size_t i = count; i-- > 0;)
      if (node.count[near[i]] == 0 && d2[near[i]] <= best2)
        stack[static_cast<std::size_t>(size++)] = {node.first[near[i]], d2[near[i]]};
  }
  if (!best_face) return result;
  result.distance = std::sqrt(best2);
  result.triangle = best_face->triangle;
  result.barycentric = Vec3(1 - best.v - best.w, best.v, best.w);
  result.point = best_face->a + best.v * best_face->ab + best.w * best_face->ac;
  return result;
}

namespace {

// Slab test; the interval grows by a few roundings, for rays within a flat box.
struct Slabs {
  Vec3 origin, inverse;

  template <class Node>
  bool hits(const Node& node, std::size_t k, double max_t) const {
    double enter = 0, leave = max_t;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      const double low = node.low[axis][k], high = node.high[axis][k];
      if (!(low <= high)) return false;
      if (std::isinf(inverse[a])) {
        if (origin[a] < low || origin[a] > high) return false;
        continue;
      }
      const double t0 = (low - origin[a]) * inverse[a], t1 = (high - origin[a]) * inverse[a];
      enter = std::max(enter, std::min(t0, t1));
      leave = std::min(leave, std::max(t0, t1));
    }
    return enter <= leave + 1e-12 * std::abs(leave);
  }
};

// Calls visit with every hit at 0 ≤ t ≤ max_t, in the order of the tree; visit may lower max_t.
template <class Nodes, class Faces, class Visit>
void visit_hits(const Nodes& nodes, const Faces& faces, const Vec3& origin, const Vec3& direction,
                const double& max_t, Visit&& visit) {
  if (faces.empty()) return;
  const Slabs ray{origin, direction.cwiseInverse()};
  std::array<Index, kStackSize> stack;
  int size = 0;
  stack[static_cast<std::size_t>(size++)] = 0;
  while (size > 0) {
    const auto& node = nodes[static_cast<std::size_t>(stack[static_cast<std::size_t>(--size)])];
    for (std::size_t k = 0; k < 4; ++k) {
      if (!ray.hits(node, k, max_t)) continue;
      if (node.count[k] == 0) stack[static_cast<std::size_t>(size++)] = node.first[k];
      for (Index i = node.first[k]; i < node.first[k] + node.count[k]; ++i) {
        const auto& face = faces[static_cast<std::size_t>(i)];
        const double t = ray_triangle(origin, direction, face.a, face.ab, face.ac);
        if (t >= 0 && t <= max_t && t < kInfinity) visit(RayHit{t, face.triangle});
      }
    }
  }
}

}  // namespace

RayHit AabbTree::first_hit(const Vec3& origin, const Vec3& direction, double max_t) const {
  RayHit best{max_t, -1};
  visit_hits(nodes_, faces_, origin, direction, best.t, [&](const RayHit& hit) {
    if (hit.t < best.t || best.triangle < 0 || hit.triangle < best.triangle) best = hit;
  });
  return best.triangle < 0 ? RayHit{} : best;
}

std::vector<RayHit> AabbTree::all_hits(const Vec3& origin, const Vec3& direction,
                                       double max_t) const {
  std::vector<RayHit> hits;
  visit_hits(nodes_, faces_, origin, direction, max_t,
             [&](const RayHit& hit) { hits.push_back(hit); });
  std::sort(hits.begin(), hits.end(), [](const RayHit& a, const RayHit& b) {
    return a.t != b.t ? a.t < b.t : a.triangle < b.triangle;
  });
  return hits;
}

void AabbTree::triangles_in_box(const Box& box, std::vector<Index>& found) const {
  found.clear();
  if (faces_.empty()) return;
  std::array<Index, kStackSize> stack;
  int size = 0;
  stack[static_cast<std::size_t>(size++)] = 0;
  while (size > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[static_cast<std::size_t>(--size)])];
    for (std::size_t k = 0; k < 4; ++k) {
      bool apart = false;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<Eigen::Index>(axis);
        apart = apart || !(node.low[axis][k] <= box.max[a] && node.high[axis][k] >= box.min[a]);
      }
      if (apart) continue;
      if (node.count[k] == 0) stack[static_cast<std::size_t>(size++)] = node.first[k];
      for (Index i = node.first[k]; i < node.first[k] + node.count[k]; ++i) {
        const Face& face = faces_[static_cast<std::size_t>(i)];
        const Vec3 b = face.a + face.ab, c = face.a + face.ac;
        // b and c come back with one rounding: the slack keeps touching boxes touching.
        const double slack =
            1e-15 * (face.a.cwiseAbs() + face.ab.cwiseAbs() + face.ac.cwiseAbs()).maxCoeff();
        const Vec3 low = face.a.cwiseMin(b).cwiseMin(c), high = face.a.cwiseMax(b).cwiseMax(c);
        if ((low.array() - slack <= box.max.array()).all() &&
            (high.array() + slack >= box.min.array()).all())
          found.push_back(face.triangle);
      }
    }
  }
}

}  // namespace s3
