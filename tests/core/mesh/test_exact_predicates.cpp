#include "mesh/exact_predicates.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

using namespace s3;

namespace {

using Wide = long long;

struct IntVec {
  Wide x, y, z;
  IntVec operator-(const IntVec& o) const { return {x - o.x, y - o.y, z - o.z}; }
};
IntVec cross(const IntVec& a, const IntVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Wide dot(const IntVec& a, const IntVec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
bool is_zero(const IntVec& a) {
  return a.x == 0 && a.y == 0 && a.z == 0;
}
int sign(Wide x) {
  return (x > 0) - (x < 0);
}

IntVec integers(const Vec3& p) {
  return {std::llround(p.x()), std::llround(p.y()), std::llround(p.z())};
}

// Separating axis theorem in integers: closed triangles are apart if and only if an axis separates
// them strictly.
bool apart_by_axes(const Corners& s, const Corners& t) {
  std::vector<IntVec> a, b;
  for (std::size_t i = 0; i < 3; ++i) a.push_back(integers(s[i])), b.push_back(integers(t[i]));
  const auto edges = [](const std::vector<IntVec>& c) {
    return std::vector<IntVec>{c[1] - c[0], c[2] - c[1], c[0] - c[2]};
  };
  const std::vector<IntVec> ea = edges(a), eb = edges(b);
  const IntVec na = cross(ea[0], ea[1]), nb = cross(eb[0], eb[1]);
  std::vector<IntVec> axes = {na, nb};
  for (const IntVec& x : ea) {
    axes.push_back(cross(na, x));
    for (const IntVec& y : eb) axes.push_back(cross(x, y));
  }
  for (const IntVec& y : eb) axes.push_back(cross(nb, y));
  for (const IntVec& axis : axes) {
    if (is_zero(axis)) continue;
    const auto [a_min, a_max] = std::minmax({dot(axis, a[0]), dot(axis, a[1]), dot(axis, a[2])});
    const auto [b_min, b_max] = std::minmax({dot(axis, b[0]), dot(axis, b[1]), dot(axis, b[2])});
    if (a_max < b_min || b_max < a_min) return true;
  }
  return false;
}

class IntegerPoints {
 public:
  explicit IntegerPoints(int range) : at_(-range, range) {}
  Vec3 operator()() { return Vec3(at_(random_), at_(random_), at_(random_)); }

 private:
  std::mt19937 random_{11};
  std::uniform_int_distribution<int> at_;
};

}  // namespace

TEST_CASE("orientation signs agree with integer determinants, often zero") {
  IntegerPoints point(4);
  int zeros = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = point(), b = point(), c = point(), d = point();
    const IntVec A = integers(a), B = integers(b), C = integers(c), D = integers(d);
    const int expected = sign(dot(A - D, cross(B - D, C - D)));
    zeros += expected == 0;
    CHECK(orient3d(a, b, c, d) == expected);
    const IntVec n = cross(B - A, C - A);
    CHECK(orient2d(a, b, c, 0) == sign(n.x));
    CHECK(orient2d(a, b, c, 1) == sign(n.y));
    CHECK(orient2d(a, b, c, 2) == sign(n.z));
    CHECK(is_degenerate({a, b, c}) == is_zero(n));
  }
  CHECK(zeros > 500);
}

TEST_CASE("orientation is exact one rounding step beside a slanted plane") {
  // On x + y + z = 3·2⁻¹ with coordinates that are not multiples of anything round.
  const double h = std::ldexp(1.0, -52);
  const Vec3 a(0.1, 0.2, 1.2 - 0.0), b(1.1, 0.3, 0.1), c(0.7, 0.7, 0.1);
  const Vec3 mid = (a + b) / 2;
  // A point moved along z by one unit in the last place changes side between the two moves.
  const int below = orient3d(a, b, c, mid - Vec3(0, 0, 4 * h)),
            above = orient3d(a, b, c, mid + Vec3(0, 0, 4 * h));
  CHECK(below * above == -1);
  // Antisymmetry holds exactly, whatever the filter decides.
  for (int k = -3; k <= 3; ++k) {
    const Vec3 d = mid + Vec3(0, 0, k * h);
    const int s = orient3d(a, b, c, d);
    CHECK(orient3d(b, a, c, d) == -s);
    CHECK(orient3d(b, c, a, d) == s);
    CHECK(orient3d(d, b, c, a) == -s);
  }
}

TEST_CASE("orientation does not drown in a large offset") {
  const Vec3 offset(1e15, -3e15, 7e14);
  const Vec3 a = offset + Vec3(0, 0, 0), b = offset + Vec3(4, 0, 0), c = offset + Vec3(0, 4, 0);
  CHECK(orient3d(a, b, c, offset + Vec3(1, 1, 0)) == 0);
  CHECK(orient3d(a, b, c, offset + Vec3(1, 1, -1)) == 1);
  CHECK(orient3d(a, b, c, offset + Vec3(1, 1, 1)) == -1);
}

TEST_CASE("two triangles meet where no integer axis separates them") {
  for (const int range : {2, 4, 12}) {
    IntegerPoints point(range);
    int meeting = 0, coplanar = 0;
    for (int i = 0; i < 8000; ++i) {
      Corners s = {point(), point(), point()}, t = {point(), point(), point()};
      if (i % 4 == 0)
        for (Vec3& p : t) p.z() = s[0].z();
      if (i % 8 == 0)
        for (Vec3& p : s) p.z() = s[0].z();
      if (is_degenerate(s) || is_degenerate(t)) continue;
      const bool expected = !apart_by_axes(s, t);
      meeting += expected;
      coplanar += i % 8 == 0;
      CHECK(triangles_meet(s, t) == expected);
      CHECK(triangles_meet(t, s) == expected);
      CHECK(triangles_meet({s[1], s[0], s[2]}, {t[2], t[1], t[0]}) == expected);
    }
    CHECK(meeting > 300);
    CHECK(coplanar > 300);
  }
}

TEST_CASE(
    "triangles with a common corner meet beyond it where shrinking them towards it does not part "
    "them") {
  // Beyond the corner ⇔ the triangles, cut off near the corner, still meet; in integers: scale by
  // 64 and move the corner of each a little into it. The cut is 1/64, and no two lattice triangles
  // of this range meet only nearer than that.
  IntegerPoints point(2);
  int meeting = 0;
  for (int i = 0; i < 6000; ++i) {
    const Vec3 o = point();
    Corners s = {o, point(), point()}, t = {o, point(), point()};
    if (i % 3 == 0) s[1].z() = s[2].z() = t[1].z() = t[2].z() = o.z();
    if (is_degenerate(s) || is_degenerate(t)) continue;
    // The opposite edges together with everything between 1/64 and 1: a quadrilateral as two
    // triangles.
    const auto cut = [&](const Corners& c) {
      const Vec3 p = 63 * o + c[1], q = 63 * o + c[2], far_p = 64 * c[1], far_q = 64 * c[2];
      return std::array<Corners, 2>{Corners{p, far_p, far_q}, Corners{p, far_q, q}};
    };
    bool expected = false;
    for (const Corners& x : cut(s))
      for (const Corners& y : cut(t)) expected = expected || !apart_by_axes(x, y);
    meeting += expected;
    CHECK(triangles_meet_beyond_corner(s, t) == expected);
    CHECK(triangles_meet_beyond_corner(t, s) == expected);
  }
  CHECK(meeting > 300);
}

TEST_CASE("triangles with a common edge overlap only when one is folded onto the other") {
  const Vec3 a(0, 0, 0), b(3, 1, 0);
  const Corners s = {a, b, Vec3(1, 2, 0)};
  CHECK(triangles_fold_over_edge(s, {a, b, Vec3(2, 5, 0)}));
  CHECK(!triangles_fold_over_edge(s, {a, b, Vec3(2, -5, 0)}));
  CHECK(!triangles_fold_over_edge(s, {a, b, Vec3(2, 5, 1e-300)}));
  CHECK(!triangles_fold_over_edge(s, {a, b, Vec3(2, 5, -1e-12)}));
}
