// Expansions and the static filters: Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic
// and Fast Robust Geometric Predicates". An expansion is a sum of doubles that do not overlap,
// smallest first; it is exact. Only the sign of the whole determinant is asked for, so that one
// plain exact evaluation behind the filter is enough.
#include "mesh/exact_predicates.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace s3 {

namespace {

constexpr double kEpsilon = 0.5 * std::numeric_limits<double>::epsilon();  // 2⁻⁵³
constexpr double kFilter3d = (7 + 56 * kEpsilon) * kEpsilon;
// Relative error of a dot product of differences, with room: three differences, products and sums
// of 2⁻⁵³ each.
constexpr double kMargin = 1e-14;
constexpr double kFilter2d = (3 + 16 * kEpsilon) * kEpsilon;

// At most N terms, which is enough for what is added to it.
template <int N>
struct Expansion {
  std::array<double, N> terms;  // the first `size` hold values
  int size = 0;

  void push(double term) { terms[static_cast<std::size_t>(size++)] = term; }
  double operator[](int i) const { return terms[static_cast<std::size_t>(i)]; }
};
using Difference = Expansion<2>;

// a + b = sum + error, exactly.
struct TwoTerms {
  double sum, error;
};

TwoTerms two_sum(double a, double b) {
  const double sum = a + b, b_virtual = sum - a;
  return {sum, (a - (sum - b_virtual)) + (b - b_virtual)};
}

TwoTerms two_product(double a, double b) {
  const auto split = [](double x) {
    const double c = 134217729.0 * x;  // 2²⁷ + 1
    const double high = c - (c - x);
    return TwoTerms{high, x - high};
  };
  const double product = a * b;
  const auto [a_high, a_low] = split(a);
  const auto [b_high, b_low] = split(b);
  return {product,
          a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)};
}

template <int N>
void add_to(Expansion<N>& e, double b) {
  double carry = b;
  const int size = e.size;
  e.size = 0;
  for (int i = 0; i < size; ++i) {
    const auto [sum, error] = two_sum(carry, e[i]);
    if (error != 0) e.push(error);
    carry = sum;
  }
  if (carry != 0) e.push(carry);
}

Difference difference(double a, double b) {
  const auto [sum, error] = two_sum(a, -b);
  Difference e;
  if (error != 0) e.push(error);
  if (sum != 0) e.push(sum);
  return e;
}

// sum += sign · a · b
template <int N, int A>
void add_product(Expansion<N>& sum, const Expansion<A>& a, const Difference& b, double sign = 1) {
  for (int i = 0; i < a.size; ++i)
    for (int j = 0; j < b.size; ++j) {
      const auto [product, error] = two_product(sign * a[i], b[j]);
      if (error != 0) add_to(sum, error);
      add_to(sum, product);
    }
}

template <int N>
int sign_of(const Expansion<N>& e) {
  return e.size == 0 ? 0 : (e[e.size - 1] > 0) - (e[e.size - 1] < 0);
}
int sign_of(double x) {
  return (x > 0) - (x < 0);
}

int exact_orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  std::array<std::array<Difference, 3>, 3> m;
  for (int k = 0; k < 3; ++k) {
    const auto col = static_cast<std::size_t>(k);
    m[0][col] = difference(a[k], d[k]);
    m[1][col] = difference(b[k], d[k]);
    m[2][col] = difference(c[k], d[k]);
  }
  Expansion<192> det;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    Expansion<16> minor;
    add_product(minor, m[1][i], m[2][j]);
    add_product(minor, m[1][j], m[2][i], -1);
    add_product(det, minor, m[0][k]);
  }
  return sign_of(det);
}

int exact_orient2d(const Vec3& a, const Vec3& b, const Vec3& c, int i, int j) {
  Expansion<16> det;
  add_product(det, difference(b[i], a[i]), difference(c[j], a[j]));
  add_product(det, difference(b[j], a[j]), difference(c[i], a[i]), -1);
  return sign_of(det);
}

// The axis along which a triangle's projection keeps an area; −1 when it has none.
int projection_axis(const Corners& t) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]).cwiseAbs();
  int best;
  n.maxCoeff(&best);
  for (int k = 0; k < 3; ++k) {
    const int axis = (best + k) % 3;
    if (orient2d(t[0], t[1], t[2], axis) != 0) return axis;
  }
  return -1;
}

bool segments_meet_2d(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, int drop) {
  const int a_side = orient2d(p, q, a, drop), b_side = orient2d(p, q, b, drop);
  const int p_side = orient2d(a, b, p, drop), q_side = orient2d(a, b, q, drop);
  if (a_side * b_side > 0 || p_side * q_side > 0) return false;
  if (a_side != 0 || b_side != 0 || p_side != 0 || q_side != 0) return true;
  // All four on one line: the intervals overlap in both coordinates.
  for (int k = 1; k <= 2; ++k) {
    const int axis = (drop + k) % 3;
    if (std::max(p[axis], q[axis]) < std::min(a[axis], b[axis]) ||
        std::max(a[axis], b[axis]) < std::min(p[axis], q[axis]))
      return false;
  }
  return true;
}

bool point_in_triangle_2d(const Vec3& p, const Corners& t, int drop) {
  const int s0 = orient2d(t[0], t[1], p, drop), s1 = orient2d(t[1], t[2], p, drop),
            s2 = orient2d(t[2], t[0], p, drop);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

bool coplanar_segment_meets(const Vec3& p, const Vec3& q, const Corners& t) {
  const int drop = projection_axis(t);
  if (drop < 0) return false;
  if (point_in_triangle_2d(p, t, drop) || point_in_triangle_2d(q, t, drop)) return true;
  for (std::size_t i = 0; i < 3; ++i)
    if (segments_meet_2d(p, q, t[i], t[(i + 1) % 3], drop)) return true;
  return false;
}

// True when a plane across `axis` certainly parts the triangles. Any axis may be tried; the margin
// covers the rounding.
bool apart_along(const Vec3& axis, const Corners& s, const Corners& t) {
  double s_low = 0, s_high = 0, t_low = std::numeric_limits<double>::infinity(), t_high = -t_low,
         size = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    const Vec3 p = s[i] - s[0];
    const double at = p.dot(axis);
    s_low = std::min(s_low, at), s_high = std::max(s_high, at);
    size = std::max(size, p.cwiseAbs().maxCoeff());
  }
  for (const Vec3& corner : t) {
    const Vec3 p = corner - s[0];
    const double at = p.dot(axis);
    t_low = std::min(t_low, at), t_high = std::max(t_high, at);
    size = std::max(size, p.cwiseAbs().maxCoeff());
  }
  const double margin = kMargin * size * axis.cwiseAbs().sum();
  return s_high + margin < t_low || t_high + margin < s_low;
}

// Normals, and within the planes the normals of the edges: what parts most pairs, also coplanar
// ones, without exact signs.
bool certainly_apart(const Corners& s, const Corners& t) {
  if (apart_along((t[0] + t[1] + t[2]) - (s[0] + s[1] + s[2]), s, t)) return true;
  for (const Corners* c : {&s, &t}) {
    const Vec3 normal = ((*c)[1] - (*c)[0]).cross((*c)[2] - (*c)[0]);
    if (apart_along(normal, s, t)) return true;
    for (std::size_t i = 0; i < 3; ++i)
      if (apart_along(normal.cross((*c)[(i + 1) % 3] - (*c)[i]), s, t)) return true;
  }
  return false;
}

// True when a plane through the common corner certainly has one triangle on either side: across the
// difference of the directions in which they leave the corner.
bool certainly_meet_in_corner_only(const Corners& s, const Corners& t) {
  const Vec3 a = s[1] - s[0], b = s[2] - s[0], c = t[1] - t[0], d = t[2] - t[0];
  const Vec3 axis = (a.normalized() + b.normalized()).normalized() -
                    (c.normalized() + d.normalized()).normalized();
  const auto beyond = [&](const Vec3& p) {
    return p.dot(axis) > kMargin * p.cwiseAbs().maxCoeff() * axis.cwiseAbs().sum();
  };
  return beyond(a) && beyond(b) && beyond(-c) && beyond(-d);
}

// All corners of t strictly on one side of the plane of s.
bool plane_separates(const Corners& s, const Corners& t) {
  const int side = orient3d(s[0], s[1], s[2], t[0]);
  return side != 0 && orient3d(s[0], s[1], s[2], t[1]) == side &&
         orient3d(s[0], s[1], s[2], t[2]) == side;
}

}  // namespace

int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = a - d, v = b - d, w = c - d;
  const double vxwy = v.x() * w.y(), wxvy = w.x() * v.y(), wxuy = w.x() * u.y(),
               uxwy = u.x() * w.y(), uxvy = u.x() * v.y(), vxuy = v.x() * u.y();
  const double det = u.z() * (vxwy - wxvy) + v.z() * (wxuy - uxwy) + w.z() * (uxvy - vxuy);
  const double permanent = (std::abs(vxwy) + std::abs(wxvy)) * std::abs(u.z()) +
                           (std::abs(wxuy) + std::abs(uxwy)) * std::abs(v.z()) +
                           (std::abs(uxvy) + std::abs(vxuy)) * std::abs(w.z());
  if (std::abs(det) > kFilter3d * permanent) return sign_of(det);
  for (int k = 0; k < 3; ++k)  // planes across an axis, which CAD models are full of
    if (a[k] == d[k] && b[k] == d[k] && c[k] == d[k]) return 0;
  return exact_orient3d(a, b, c, d);
}

int orient2d(const Vec3& a, const Vec3& b, const Vec3& c, int drop) {
  const int i = (drop + 1) % 3, j = (drop + 2) % 3;
  const double left = (b[i] - a[i]) * (c[j] - a[j]), right = (b[j] - a[j]) * (c[i] - a[i]);
  const double det = left - right;
  if (std::abs(det) > kFilter2d * (std::abs(left) + std::abs(right))) return sign_of(det);
  return exact_orient2d(a, b, c, i, j);
}

bool is_degenerate(const Corners& triangle) {
  return projection_axis(triangle) < 0;
}

bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Corners& t) {
  const int p_side = orient3d(t[0], t[1], t[2], p), q_side = orient3d(t[0], t[1], t[2], q);
  if (p_side * q_side > 0) return false;
  if (p_side == 0 && q_side == 0) return coplanar_segment_meets(p, q, t);
  const int s0 = orient3d(p, q, t[0], t[1]), s1 = orient3d(p, q, t[1], t[2]);
  if (s0 * s1 < 0) return false;
  const int s2 = orient3d(p, q, t[2], t[0]);
  return s0 * s2 >= 0 && s1 * s2 >= 0;
}

bool triangles_meet(const Corners& s, const Corners& t) {
  if (certainly_apart(s, t)) return false;
  if (plane_separates(s, t) || plane_separates(t, s)) return false;
  for (std::size_t i = 0; i < 3; ++i)
    if (segment_meets_triangle(s[i], s[(i + 1) % 3], t) ||
        segment_meets_triangle(t[i], t[(i + 1) % 3], s))
      return true;
  return false;
}

bool triangles_meet_beyond_corner(const Corners& s, const Corners& t) {
  if (certainly_meet_in_corner_only(s, t)) return false;
  // Wherever they overlap, a ray from the common corner leaves one of them through its opposite
  // edge.
  return segment_meets_triangle(s[1], s[2], t) || segment_meets_triangle(t[1], t[2], s);
}

bool triangles_fold_over_edge(const Corners& s, const Corners& t) {
  const Vec3 edge = s[1] - s[0], u = s[2] - s[0], v = t[2] - s[0];
  // Folded triangles have equal normals when both are seen along the common edge.
  if (edge.cross(u).dot(edge.cross(v)) < -kMargin * 10 * edge.squaredNorm() * u.norm() * v.norm())
    return false;
  if (orient3d(s[0], s[1], s[2], t[2]) != 0) return false;
  const int drop = projection_axis(s);
  return drop >= 0 && orient2d(s[0], s[1], s[2], drop) * orient2d(s[0], s[1], t[2], drop) > 0;
}

}  // namespace s3
