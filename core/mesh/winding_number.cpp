// Solid angle of a triangle: Van Oosterom and Strackee 1983. Expansion: Barill, Dickson, Schmidt,
// Levin, Jacobson 2018, "Fast Winding Numbers for Soups and Clouds", Eq. 12 to 16.
#include "mesh/winding_number.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"

namespace s3 {

namespace {

constexpr std::size_t kLeafSize = 8;
// A node's expansion stands for its triangles beyond this many radii (β of the paper, which takes
// 2).
constexpr double kAccuracy = 2.5;
// The tree halves by count: 2³¹ triangles are 31 levels.
constexpr std::size_t kStackSize = 64;

// Solid angle over 4π: tan(Ω/2) = a·(b×c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|).
double solid_angle_share(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  if (numerator == 0 && denominator >= 0) return 0;
  return std::atan2(numerator, denominator) / (2 * kPi);
}

}  // namespace

WindingNumber::WindingNumber(const TriMesh& mesh) {
  const auto n = static_cast<std::size_t>(mesh.triangles.rows());
  faces_.reserve(n);
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    const auto corner = [&](int i) -> Vec3 { return mesh.vertices.row(mesh.triangles(f, i)); };
    faces_.push_back({corner(0), corner(1), corner(2)});
  }
  if (n == 0) return;
  nodes_.reserve(4 * n / kLeafSize + 1);
  build(0, n);
}

Index WindingNumber::build(std::size_t begin, std::size_t end) {
  const auto index = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  Node node;
  node.begin = static_cast<Index>(begin);
  node.end = static_cast<Index>(end);
  expand(node);
  if (end - begin > kLeafSize) {
    const auto center = [](const Face& f, int axis) { return f.a[axis] + f.b[axis] + f.c[axis]; };
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 c = faces_[i].a + faces_[i].b + faces_[i].c;
      low = low.cwiseMin(c);
      high = high.cwiseMax(c);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return faces_.begin() + static_cast<std::ptrdiff_t>(i); };
    // A full sort: nth_element leaves an order that depends on the library.
    std::stable_sort(at(begin), at(end), [&](const Face& f, const Face& g) {
      return center(f, axis) < center(g, axis);
    });
    node.child[0] = build(begin, middle);
    node.child[1] = build(middle, end);
  }
  nodes_[static_cast<std::size_t>(index)] = node;
  return index;
}

void WindingNumber::expand(Node& node) const {
  double area = 0;
  Vec3 sum = Vec3::Zero(), plain_sum = Vec3::Zero();
  for (Index i = node.begin; i < node.end; ++i) {
    const Face& f = faces_[static_cast<std::size_t>(i)];
    const double a = (f.b - f.a).cross(f.c - f.a).norm();
    const Vec3 centroid = (f.a + f.b + f.c) / 3;
    area += a;
    sum += a * centroid;
    plain_sum += centroid;
  }
  node.center = area > 0 ? Vec3(sum / area) : Vec3(plain_sum / (node.end - node.begin));

  double radius2 = 0;
  for (Index i = node.begin; i < node.end; ++i) {
    const Face& f = faces_[static_cast<std::size_t>(i)];
    const Vec3 a = f.a - node.center, b = f.b - node.center, c = f.c - node.center;
    radius2 = std::max({radius2, a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
    const Vec3 n = 0.5 * (b - a).cross(c - a);  // with the area
    const Vec3 s = a + b + c, d = s / 3;
    node.dipole += n;
    // ∫ d dA = area · centroid
    const auto m = [&](int i, int j) { return 0.5 * (n[i] * d[j] + n[j] * d[i]); };
    node.first[0] += m(0, 0);
    node.first[1] += m(1, 1);
    node.first[2] += m(2, 2);
    node.first[3] += m(1, 2);
    node.first[4] += m(2, 0);
    node.first[5] += m(0, 1);
    // ∫ d⊗d dA = area/12 (a⊗a + b⊗b + c⊗c + s⊗s)
    const Mat3 q =
        (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose()) / 12;
    const auto t = [&](int i, int j, int k) {
      return (n[i] * q(j, k) + n[j] * q(k, i) + n[k] * q(i, j)) / 3;
    };
    constexpr std::array<std::array<int, 3>, 10> kTriples = {{{0, 0, 0},
                                                              {1, 1, 1},
                                                              {2, 2, 2},
                                                              {0, 0, 1},
                                                              {0, 0, 2},
                                                              {1, 1, 0},
                                                              {1, 1, 2},
                                                              {2, 2, 0},
                                                              {2, 2, 1},
                                                              {0, 1, 2}}};
    for (std::size_t k = 0; k < kTriples.size(); ++k)
      node.second[k] += t(kTriples[k][0], kTriples[k][1], kTriples[k][2]);
  }
  node.radius = std::sqrt(radius2);
}

// With F(r) = r/|r|³ the winding number is ∫ n·F(x − p)/4π; this is F's Taylor series about the
// node's centre.
double WindingNumber::far_field(const Node& node, const Vec3& p) {
  const Vec3 r = node.center - p;
  const double r2 = r.squaredNorm(), inverse2 = 1 / r2, inverse3 = inverse2 / std::sqrt(r2);
  const double x = r[0], y = r[1], z = r[2];
  // ∂_j F_i = δ_ij/|r|³ − 3 r_i r_j/|r|⁵
  const auto& m = node.first;
  const double m_rr =
      m[0] * x * x + m[1] * y * y + m[2] * z * z + 2 * (m[3] * y * z + m[4] * z * x + m[5] * x * y);
  const double order1 = m[0] + m[1] + m[2] - 3 * m_rr * inverse2;
  // ∂_j ∂_k F_i = −3 (δ_ij r_k + δ_jk r_i + δ_ki r_j)/|r|⁵ + 15 r_i r_j r_k/|r|⁷
  const auto& t = node.second;
  const double t_trace =
      (t[0] + t[5] + t[7]) * x + (t[3] + t[1] + t[8]) * y + (t[4] + t[6] + t[2]) * z;
  const double t_rrr = t[0] * x * x * x + t[1] * y * y * y + t[2] * z * z * z +
                       3 * (t[3] * x * x * y + t[4] * x * x * z + t[5] * y * y * x +
                            t[6] * y * y * z + t[7] * z * z * x + t[8] * z * z * y) +
                       6 * t[9] * x * y * z;
  const double order2 = 0.5 * (-9 * t_trace + 15 * t_rrr * inverse2) * inverse2;
  return (node.dipole.dot(r) + order1 + order2) * inverse3 / (4 * kPi);
}

double WindingNumber::at(const Vec3& p) const {
  if (nodes_.empty()) return 0;
  std::array<Index, kStackSize> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  double w = 0;
  while (size > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[--size])];
    const double reach = kAccuracy * node.radius;
    if ((node.center - p).squaredNorm() > reach * reach) {
      w += far_field(node, p);
    } else if (node.child[0] >= 0) {
      stack[size++] = node.child[1];
      stack[size++] = node.child[0];
    } else {
      for (Index i = node.begin; i < node.end; ++i) {
        const Face& f = faces_[static_cast<std::size_t>(i)];
        w += solid_angle_share(f.a - p, f.b - p, f.c - p);
      }
    }
  }
  return w;
}

double WindingNumber::exact(const Vec3& p) const {
  double w = 0;
  for (const Face& f : faces_) w += solid_angle_share(f.a - p, f.b - p, f.c - p);
  return w;
}

}  // namespace s3
