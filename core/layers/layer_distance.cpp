// Closest points on triangles: C. Ericson, Real-Time Collision Detection, Sec. 5.1.5 (Voronoi
// regions of a triangle).
#include "layers/layer_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace s3 {
namespace {

constexpr Index kLeafSize = 4;

Vec3 closest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& t) {
  const Vec3 &a = t[0], &b = t[1], &c = t[2];
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 > d3 ? d1 / (d1 - d3) : 0.0) * ab;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 > d6 ? d2 / (d2 - d6) : 0.0) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double sum = (d4 - d3) + (d5 - d6);
    return b + (sum > 0 ? (d4 - d3) / sum : 0.0) * (c - b);
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return a;
  return a + (vb / sum) * ab + (vc / sum) * ac;
}

}  // namespace

SurfaceTree::SurfaceTree(const TriMesh& surface) {
  const Index n = static_cast<Index>(surface.triangles.rows());
  if (n == 0) return;
  std::vector<Vec3> centers(n);
  for (Index f = 0; f < n; ++f) {
    centers[f].setZero();
    for (int i = 0; i < 3; ++i)
      centers[f] += surface.vertices.row(surface.triangles(f, i)).transpose() / 3.0;
  }
  triangle_.resize(n);
  std::iota(triangle_.begin(), triangle_.end(), 0);
  corners_.resize(n);
  for (Index f = 0; f < n; ++f)
    for (int i = 0; i < 3; ++i) corners_[f][i] = surface.vertices.row(surface.triangles(f, i));
  nodes_.reserve(2 * (n / 2) + 1);
  Node root;
  root.end = n;
  nodes_.push_back(root);
  build(0, triangle_, centers);
  std::vector<std::array<Vec3, 3>> sorted(n);
  for (Index k = 0; k < n; ++k) sorted[k] = corners_[triangle_[k]];
  corners_ = std::move(sorted);
}

// Halves the triangles at the median of their centres along the longest axis.
void SurfaceTree::build(Index node, std::vector<Index>& order, const std::vector<Vec3>& centers) {
  const Index begin = nodes_[node].begin, end = nodes_[node].end;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  Vec3 center_low = low, center_high = high;
  for (Index k = begin; k < end; ++k) {
    for (const Vec3& corner : corners_[order[k]]) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    center_low = center_low.cwiseMin(centers[order[k]]);
    center_high = center_high.cwiseMax(centers[order[k]]);
  }
  nodes_[node].min = low;
  nodes_[node].max = high;
  if (end - begin <= kLeafSize) return;
  int axis = 0;
  (center_high - center_low).maxCoeff(&axis);
  const Index middle = begin + (end - begin) / 2;
  std::nth_element(
      order.begin() + begin, order.begin() + middle, order.begin() + end, [&](Index a, Index b) {
        return centers[a](axis) != centers[b](axis) ? centers[a](axis) < centers[b](axis) : a < b;
      });
  const Index left = static_cast<Index>(nodes_.size());
  nodes_[node].left = left;
  Node child;
  child.begin = begin;
  child.end = middle;
  nodes_.push_back(child);
  child.begin = middle;
  child.end = end;
  nodes_.push_back(child);
  build(left, order, centers);
  build(left + 1, order, centers);
}

double SurfaceTree::box_distance_squared(const Node& node, const Vec3& p) {
  return (node.min - p).cwiseMax(p - node.max).cwiseMax(0.0).squaredNorm();
}

double SurfaceTree::box_distance(const Vec3& p) const {
  return nodes_.empty() ? std::numeric_limits<double>::infinity()
                        : std::sqrt(box_distance_squared(nodes_[0], p));
}

SurfaceTree::Closest SurfaceTree::closest(const Vec3& p, double bound) const {
  Closest best;
  best.distance = bound;
  if (nodes_.empty()) return best;
  double best_squared = bound * bound;
  std::array<std::pair<double, Index>, 64> stack;  // depth ≤ 31: halving
  int top = 0;
  stack[top++] = {box_distance_squared(nodes_[0], p), 0};
  while (top > 0) {
    const auto [distance, index] = stack[--top];
    if (distance >= best_squared) continue;
    const Node& node = nodes_[index];
    if (node.left < 0) {
      for (Index k = node.begin; k < node.end; ++k) {
        const Vec3 q = closest_on_triangle(p, corners_[k]);
        const double d = (q - p).squaredNorm();
        if (d < best_squared) {
          best_squared = d;
          best.triangle = triangle_[k];
          best.point = q;
        }
      }
      continue;
    }
    const double left = box_distance_squared(nodes_[node.left], p);
    const double right = box_distance_squared(nodes_[node.left + 1], p);
    const bool left_first = left <= right;
    // The nearer child last: it is taken from the stack first.
    stack[top++] = left_first ? std::pair{right, node.left + 1} : std::pair{left, node.left};
    stack[top++] = left_first ? std::pair{left, node.left} : std::pair{right, node.left + 1};
  }
  if (best.triangle >= 0) best.distance = std::sqrt(best_squared);
  return best;
}

double PrintedMaterial::distance(const Vec3& p, double bound) const {
  double best = std::min(bound, std::max(p.z(), 0.0));
  for (auto tree = trees_.rbegin(); tree != trees_.rend(); ++tree)
    if (tree->box_distance(p) < best) best = tree->closest(p, best).distance;
  return best;
}

}  // namespace s3
