#include "tetrahedralize/boundary_check.h"

#include <algorithm>
#include <array>

namespace s3 {

namespace {

// An edge of a boundary face, smaller end first.
struct FaceEdge {
  std::array<Index, 2> ends;
  Index face;
  bool operator<(const FaceEdge& o) const { return ends != o.ends ? ends < o.ends : face < o.face; }
};

// A corner of a boundary face: its number is 3·face + local corner.
struct Corners {
  std::vector<Index> parent;  // corners of one fan are joined

  Index root(Index c) {
    while (parent[static_cast<std::size_t>(c)] != c) {
      Index& up = parent[static_cast<std::size_t>(c)];
      up = parent[static_cast<std::size_t>(up)];
      c = up;
    }
    return c;
  }
  void join(Index a, Index b) { parent[static_cast<std::size_t>(root(a))] = root(b); }
};

}  // namespace

std::vector<Index> nonmanifold_boundary_vertices(const TetMesh& mesh) {
  const auto n = static_cast<Index>(mesh.boundary_faces.rows());
  std::vector<FaceEdge> edges;
  edges.reserve(static_cast<std::size_t>(3 * n));
  for (Index f = 0; f < n; ++f)
    for (int i = 0; i < 3; ++i) {
      const Index a = mesh.boundary_faces(f, i), b = mesh.boundary_faces(f, (i + 1) % 3);
      edges.push_back({{std::min(a, b), std::max(a, b)}, f});
    }
  std::sort(edges.begin(), edges.end());

  Corners corners;
  corners.parent.resize(static_cast<std::size_t>(3 * n));
  for (Index c = 0; c < 3 * n; ++c) corners.parent[static_cast<std::size_t>(c)] = c;
  const auto corner_of = [&](Index face, Index vertex) {
    int i = 0;
    while (mesh.boundary_faces(face, i) != vertex) ++i;
    return 3 * face + i;
  };
  std::vector<Index> bad;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].ends == edges[i].ends) ++end;
    if (end - i == 2) {
      for (const Index v : edges[i].ends)
        corners.join(corner_of(edges[i].face, v), corner_of(edges[i + 1].face, v));
    } else {
      bad.insert(bad.end(), edges[i].ends.begin(), edges[i].ends.end());
    }
    i = end;
  }
  std::vector<Index> fans(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (Index c = 0; c < 3 * n; ++c)
    if (corners.root(c) == c) {
      const Index v = mesh.boundary_faces(c / 3, c % 3);
      if (++fans[static_cast<std::size_t>(v)] == 2) bad.push_back(v);
    }
  std::sort(bad.begin(), bad.end());
  bad.erase(std::unique(bad.begin(), bad.end()), bad.end());
  return bad;
}

}  // namespace s3
