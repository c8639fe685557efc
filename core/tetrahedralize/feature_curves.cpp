#include "tetrahedralize/feature_curves.h"

#include <algorithm>
#include <array>

#include "mesh/weld.h"

namespace s3 {

namespace {

// Sharp edges that meet in one vertex are one curve when they turn by less than the angle of this
// cosine.
constexpr double kTurnCosine = 0.6967067093471654;  // 46°

struct HalfEdge {
  Index low, high;
  Index face;
  bool forward;  // runs from low to high
  bool operator<(const HalfEdge& o) const {
    return std::array{low, high, face} < std::array{o.low, o.high, o.face};
  }
};

struct WeldedMesh {
  Points vertices;
  Triangles triangles;
};

// Files such as STL repeat vertices; edges are told by coordinates.
WeldedMesh welded(const TriMesh& mesh) {
  Welder welder(static_cast<std::size_t>(mesh.vertices.rows()));
  std::vector<Index> vertex(static_cast<std::size_t>(mesh.vertices.rows()));
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    vertex[static_cast<std::size_t>(v)] = welder.add(mesh.vertices.row(v));
  WeldedMesh result{Points(), mesh.triangles};
  for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i)
    result.triangles.data()[i] = vertex[static_cast<std::size_t>(mesh.triangles.data()[i])];
  result.vertices = welder.take();
  return result;
}

std::vector<std::array<Index, 2>> sharp_edges(const WeldedMesh& mesh) {
  std::vector<HalfEdge> halves;
  Directions normals(mesh.triangles.rows(), 3);
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    const Vec3 n = triangle_normal_2a(mesh.vertices, mesh.triangles.row(f));
    const double length = n.norm();
    normals.row(f) = length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
    if (!(length > 0)) continue;
    for (int i = 0; i < 3; ++i) {
      const Index a = mesh.triangles(f, i), b = mesh.triangles(f, (i + 1) % 3);
      halves.push_back({std::min(a, b), std::max(a, b), f, a < b});
    }
  }
  std::sort(halves.begin(), halves.end());
  std::vector<std::array<Index, 2>> sharp;
  for (std::size_t i = 0; i < halves.size();) {
    std::size_t end = i + 1;
    while (end < halves.size() && halves[end].low == halves[i].low &&
           halves[end].high == halves[i].high)
      ++end;
    if (end - i == 2 && halves[i].forward != halves[i + 1].forward &&
        normals.row(halves[i].face).dot(normals.row(halves[i + 1].face)) < kSharpCosine)
      sharp.push_back({halves[i].low, halves[i].high});
    i = end;
  }
  return sharp;
}

// A vertex where other than two sharp edges meet, or two at an angle.
bool is_corner(const Points& vertices, Index v, const std::vector<Index>& others) {
  if (others.size() != 2) return others.size() > 2;
  const Vec3 p = vertices.row(v);
  const Vec3 in = (p - Vec3(vertices.row(others[0]))).normalized(),
             out = (Vec3(vertices.row(others[1])) - p).normalized();
  return in.dot(out) < kTurnCosine;
}

}  // namespace

FeatureCurves feature_curves(const TriMesh& surface) {
  const WeldedMesh mesh = welded(surface);
  const std::vector<std::array<Index, 2>> sharp = sharp_edges(mesh);
  FeatureCurves curves;
  std::vector<std::vector<Index>> others(static_cast<std::size_t>(mesh.vertices.rows()));
  Triangles segments(static_cast<Eigen::Index>(sharp.size()), 3);
  for (std::size_t e = 0; e < sharp.size(); ++e) {
    const auto [a, b] = sharp[e];
    others[static_cast<std::size_t>(a)].push_back(b);
    others[static_cast<std::size_t>(b)].push_back(a);
    segments.row(static_cast<Eigen::Index>(e)) << a, b, b;
  }
  for (Index v = 0; v < mesh.vertices.rows(); ++v)
    if (is_corner(mesh.vertices, v, others[static_cast<std::size_t>(v)]))
      curves.corners.emplace_back(mesh.vertices.row(v));
  curves.segments = AabbTree(mesh.vertices, segments);
  return curves;
}

}  // namespace s3
