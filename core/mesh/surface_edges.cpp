#include "mesh/surface_edges.h"

namespace s3 {

bool has_repeated_corner(const TriMesh& mesh, Eigen::Index f) {
  const auto t = mesh.triangles.row(f);
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

// Counting sort by the lower vertex, then a sort of its few sides.
std::vector<Side> sorted_sides(const TriMesh& mesh) {
  const auto for_each_side = [&](auto&& body) {
    for (Index f = 0; f < mesh.triangles.rows(); ++f) {
      if (has_repeated_corner(mesh, f)) continue;
      for (int i = 0; i < 3; ++i) {
        const Index from = mesh.triangles(f, i), to = mesh.triangles(f, (i + 1) % 3);
        body(Side{std::min(from, to), std::max(from, to), 3 * f + i, from < to});
      }
    }
  };
  std::vector<std::size_t> end(static_cast<std::size_t>(mesh.vertices.rows()) + 1, 0);
  for_each_side([&](const Side& side) { ++end[static_cast<std::size_t>(side.low) + 1]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Side> sides(end.back());
  for_each_side([&](const Side& side) { sides[end[static_cast<std::size_t>(side.low)]++] = side; });
  for (std::size_t v = 0, begin = 0; v + 1 < end.size(); begin = end[v++])
    std::sort(sides.begin() + static_cast<std::ptrdiff_t>(begin),
              sides.begin() + static_cast<std::ptrdiff_t>(end[v]));
  return sides;
}

Index corner_at(const TriMesh& mesh, const Side& side, Index vertex) {
  const Index f = side.corner / 3, i = side.corner % 3;
  return mesh.triangles(f, i) == vertex ? side.corner : 3 * f + (i + 1) % 3;
}

Index tip_of(const TriMesh& mesh, const Side& side) {
  return mesh.triangles(side.corner / 3, (side.corner % 3 + 2) % 3);
}

Vec3 centroid_of(const TriMesh& mesh, Index f) {
  return (mesh.vertices.row(mesh.triangles(f, 0)) + mesh.vertices.row(mesh.triangles(f, 1)) +
          mesh.vertices.row(mesh.triangles(f, 2)))
             .transpose() /
         3;
}

bool is_closed_and_oriented(const std::vector<Side>& sides) {
  bool good = true;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    good = good && end - begin == 2 && sides[begin].forward != sides[begin + 1].forward;
  });
  return good;
}

std::vector<Index> connected_parts(const TriMesh& mesh, const std::vector<Side>& sides,
                                   bool manifold_only, Index& count) {
  const auto n = static_cast<std::size_t>(mesh.triangles.rows());
  DisjointSets sets(n);
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (manifold_only && end - begin != 2) return;
    for (std::size_t i = begin + 1; i < end; ++i)
      sets.join(sides[begin].triangle(), sides[i].triangle());
  });
  std::vector<Index> part(n, -1);
  count = 0;
  for (std::size_t f = 0; f < n; ++f) {
    const auto leader = static_cast<std::size_t>(sets.find(static_cast<Index>(f)));
    part[f] = leader == f ? count++ : part[leader];
  }
  return part;
}

void keep_triangles(TriMesh& mesh, const std::vector<char>& keep) {
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    if (keep[static_cast<std::size_t>(f)]) mesh.triangles.row(kept++) = mesh.triangles.row(f);
  mesh.triangles.conservativeResize(kept, 3);
}

Index drop_unused_vertices(TriMesh& mesh) {
  std::vector<Index> number(static_cast<std::size_t>(mesh.vertices.rows()), -1);
  for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i)
    number[static_cast<std::size_t>(mesh.triangles.data()[i])] = 0;
  Index kept = 0;
  for (Index v = 0; v < mesh.vertices.rows(); ++v) {
    if (number[static_cast<std::size_t>(v)] < 0) continue;
    mesh.vertices.row(kept) = mesh.vertices.row(v);
    number[static_cast<std::size_t>(v)] = kept++;
  }
  const auto dropped = static_cast<Index>(mesh.vertices.rows()) - kept;
  if (dropped == 0) return 0;
  mesh.vertices.conservativeResize(kept, 3);
  for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i)
    mesh.triangles.data()[i] = number[static_cast<std::size_t>(mesh.triangles.data()[i])];
  return dropped;
}

}  // namespace s3
