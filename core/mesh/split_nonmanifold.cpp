#include "mesh/split_nonmanifold.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/stitch.h"

namespace s3 {

namespace {

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

// Pairs around one edge. Seen along low→high, solid lies at growing angles from a backward triangle
// and ends at a forward one: pairs are matching brackets on a circle.
class EdgePairing {
 public:
  EdgePairing(const TriMesh& mesh, const std::vector<Side>& sides) : mesh_(mesh), sides_(sides) {}

  void pair(std::size_t begin, std::size_t end, std::vector<Index>& partner) {
    sort_by_angle(begin, end);
    open_.clear();
    for (int round = 0; round < 2; ++round)
      for (const auto& [angle, side] : around_) {
        if (!sides_[side].forward) {
          if (round == 0) open_.push_back(side);
        } else if (partner[side] < 0 && !open_.empty()) {
          partner[side] = static_cast<Index>(open_.back());
          partner[open_.back()] = static_cast<Index>(side);
          open_.pop_back();
        }
      }
  }

 private:
  void sort_by_angle(std::size_t begin, std::size_t end) {
    const Vec3 low = vertex_of(mesh_, sides_[begin].low);
    const Vec3 axis = (vertex_of(mesh_, sides_[begin].high) - low).normalized();
    const auto away = [&](std::size_t side) {
      const Vec3 d = vertex_of(mesh_, tip_of(mesh_, sides_[side])) - low;
      return Vec3(d - d.dot(axis) * axis);
    };
    const Vec3 x = away(begin).normalized(), y = axis.cross(x);
    around_.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 d = away(i);
      around_.emplace_back(i == begin ? 0 : std::atan2(d.dot(y), d.dot(x)), i);
    }
    std::sort(around_.begin(), around_.end());
  }

  const TriMesh& mesh_;
  const std::vector<Side>& sides_;
  std::vector<std::pair<double, std::size_t>> around_;
  std::vector<std::size_t> open_;
};

}  // namespace

std::vector<Index> paired_sides(const TriMesh& mesh, const std::vector<Side>& sides) {
  std::vector<Index> partner(sides.size(), -1);
  EdgePairing pairing(mesh, sides);
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin == 2 && sides[begin].forward != sides[begin + 1].forward) {
      partner[begin] = static_cast<Index>(begin + 1);
      partner[begin + 1] = static_cast<Index>(begin);
    } else if (end - begin > 2) {
      pairing.pair(begin, end, partner);
    }
  });
  return partner;
}

Defect split_nonmanifold(TriMesh& mesh) {
  Defect doubled;
  const std::vector<Side> sides = sorted_sides(mesh);
  const std::vector<Index> partner = paired_sides(mesh, sides);
  DisjointSets fans(static_cast<std::size_t>(mesh.triangles.size()));
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (partner[i] > static_cast<Index>(i))
      for (const Index v : {sides[i].low, sides[i].high})
        fans.join(corner_at(mesh, sides[i], v), corner_at(mesh, sides[at(partner[i])], v));
  // The first fan keeps the vertex.
  std::vector<Index> first_fan(at(static_cast<Index>(mesh.vertices.rows())), -1);
  std::vector<Index> vertex_of_fan(static_cast<std::size_t>(mesh.triangles.size()), -1);
  std::vector<Index> originals;
  const auto old_count = static_cast<Index>(mesh.vertices.rows());
  for (Index c = 0; c < static_cast<Index>(mesh.triangles.size()); ++c) {
    const Index fan = fans.find(c), v = mesh.triangles(c / 3, c % 3);
    if (fan != c) continue;
    if (first_fan[at(v)] < 0) {
      first_fan[at(v)] = fan;
      vertex_of_fan[at(fan)] = v;
    } else {
      vertex_of_fan[at(fan)] = old_count + static_cast<Index>(originals.size());
      originals.push_back(v);
      doubled.add(mesh.vertices.row(v));
    }
  }
  if (originals.empty()) return doubled;
  mesh.vertices.conservativeResize(old_count + static_cast<Eigen::Index>(originals.size()), 3);
  for (std::size_t i = 0; i < originals.size(); ++i)
    mesh.vertices.row(old_count + static_cast<Eigen::Index>(i)) = mesh.vertices.row(originals[i]);
  for (Index c = 0; c < static_cast<Index>(mesh.triangles.size()); ++c)
    mesh.triangles(c / 3, c % 3) = vertex_of_fan[at(fans.find(c))];
  return doubled;
}

MeshReport inspect_split(const TriMesh& mesh, const Context* ctx) {
  MeshReport report = inspect_surface(mesh, ctx);
  if (report.self_intersections.count == 0) return report;
  TriMesh welded = mesh;
  if (weld_equal_vertices(welded).count == 0 || welded.triangles.rows() != mesh.triangles.rows())
    return report;
  MeshReport conforming = inspect_surface(welded, ctx);
  report.self_intersections = std::move(conforming.self_intersections);
  report.intersecting_pairs = std::move(conforming.intersecting_pairs);
  return report;
}

}  // namespace s3
