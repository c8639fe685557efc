#include "layers/layer_parts.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <unordered_map>

namespace s3 {
namespace {

// Cut points keep this share of an edge's length away from its ends, so that no triangle is without
// area.
constexpr double kEndClearance = 1e-3;
constexpr double kSnap = 0.1;

Index find_root(std::vector<Index>& parent, Index v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

// Copies chosen triangles with the vertices they use.
SurfacePart extract_triangles(const Isosurface& whole, const std::vector<Index>& faces,
                              std::vector<Index>& number) {
  SurfacePart result;
  Isosurface& part = result.surface;
  std::vector<Index>& used = result.vertices;
  part.surface.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  part.source_tet.reserve(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const Index v = whole.surface.triangles(faces[f], i);
      if (number[v] < 0) {
        number[v] = static_cast<Index>(used.size());
        used.push_back(v);
      }
      part.surface.triangles(static_cast<Eigen::Index>(f), i) = number[v];
    }
    part.source_tet.push_back(whole.source_tet[faces[f]]);
  }
  part.surface.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
  part.normal.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t k = 0; k < used.size(); ++k) {
    part.surface.vertices.row(static_cast<Eigen::Index>(k)) = whole.surface.vertices.row(used[k]);
    part.normal.row(static_cast<Eigen::Index>(k)) = whole.normal.row(used[k]);
    number[used[k]] = -1;
  }
  return result;
}

}  // namespace

SurfaceEdges::SurfaceEdges(const Triangles& triangles, Index vertices)
    : of_triangle(triangles.rows(), 3) {
  std::vector<Index> head(static_cast<std::size_t>(vertices), -1),
      link;  // edges by their smaller vertex
  std::vector<std::pair<Index, Index>> list;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(triangles(f, i), triangles(f, (i + 1) % 3));
      Index e = head[a];
      while (e >= 0 && list[e].second != b) e = link[e];
      if (e < 0) {
        e = static_cast<Index>(list.size());
        list.emplace_back(a, b);
        link.push_back(head[a]);
        head[a] = e;
      }
      of_triangle(f, i) = e;
    }
  ends.resize(static_cast<Eigen::Index>(list.size()), 2);
  for (std::size_t e = 0; e < list.size(); ++e)
    ends.row(static_cast<Eigen::Index>(e)) << list[e].first, list[e].second;
}

Isosurface split_edges(const Isosurface& surface, const SurfaceEdges& edges,
                       const std::vector<char>& marked) {
  const Triangles& triangles = surface.surface.triangles;
  std::vector<Index> middle(marked.size(), -1);
  Index vertices = static_cast<Index>(surface.surface.vertices.rows());
  for (std::size_t e = 0; e < marked.size(); ++e)
    if (marked[e]) middle[e] = vertices++;
  Isosurface out;
  out.surface.vertices.resize(vertices, 3);
  out.normal.resize(vertices, 3);
  out.surface.vertices.topRows(surface.surface.vertices.rows()) = surface.surface.vertices;
  out.normal.topRows(surface.normal.rows()) = surface.normal;
  for (std::size_t e = 0; e < marked.size(); ++e) {
    if (!marked[e]) continue;
    const auto ends = edges.ends.row(static_cast<Eigen::Index>(e));
    out.surface.vertices.row(middle[e]) =
        0.5 * (surface.surface.vertices.row(ends(0)) + surface.surface.vertices.row(ends(1)));
    const Vec3 normal = (surface.normal.row(ends(0)) + surface.normal.row(ends(1))).transpose();
    const double length = normal.norm();
    out.normal.row(middle[e]) = length > 0
                                    ? Vec3(normal / length).transpose()
                                    : Vec3(surface.normal.row(ends(0)).transpose()).transpose();
  }
  std::vector<std::array<Index, 3>> faces;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    std::array<Index, 3> m;
    for (int i = 0; i < 3; ++i) m[i] = middle[edges.of_triangle(f, i)];
    const int count = (m[0] >= 0) + (m[1] >= 0) + (m[2] >= 0);
    const auto emit = [&](Index a, Index b, Index c) {
      faces.push_back({a, b, c});
      out.source_tet.push_back(surface.source_tet[static_cast<std::size_t>(f)]);
    };
    // Turned so that the odd edge out comes first: the only marked one, or the only unmarked one.
    int first = 0;
    while (count > 0 && count < 3 && (m[first] >= 0) != (count == 1)) ++first;
    const int second = (first + 1) % 3, third = (first + 2) % 3;
    const Index a = triangles(f, first), b = triangles(f, second), c = triangles(f, third);
    switch (count) {
      case 0:
        emit(a, b, c);
        break;
      case 1:
        emit(a, m[first], c);
        emit(m[first], b, c);
        break;
      case 2:
        emit(a, b, m[second]);
        emit(a, m[second], m[third]);
        emit(m[third], m[second], c);
        break;
      default:
        emit(a, m[0], m[2]);
        emit(m[0], b, m[1]);
        emit(m[2], m[1], c);
        emit(m[0], m[1], m[2]);
    }
  }
  out.surface.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    out.surface.triangles.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1],
        faces[f][2];
  return out;
}

Isosurface cut_where_negative(const Isosurface& surface, const Values& value) {
  const Triangles& triangles = surface.surface.triangles;
  const auto n = static_cast<std::size_t>(surface.surface.vertices.rows());
  std::vector<Vec3> points(n), normals(n);
  for (std::size_t v = 0; v < n; ++v) {
    points[v] = surface.surface.vertices.row(static_cast<Eigen::Index>(v)).transpose();
    normals[v] = surface.normal.row(static_cast<Eigen::Index>(v)).transpose();
  }
  std::unordered_map<std::uint64_t, Index> cut_points;  // looked up only, never iterated
  const auto cut_point = [&](Index inside, Index outside) {
    const auto key =
        (static_cast<std::uint64_t>(inside) << 32) | static_cast<std::uint32_t>(outside);
    const auto [place, is_new] = cut_points.try_emplace(key, static_cast<Index>(points.size()));
    if (is_new) {
      const double s = std::clamp(value(inside) / (value(inside) - value(outside)), kEndClearance,
                                  1 - kEndClearance);
      const Vec3 point = (1 - s) * points[inside] + s * points[outside];
      const Vec3 normal = (1 - s) * normals[inside] + s * normals[outside];
      points.push_back(point);
      normals.push_back(normal.norm() > 0 ? Vec3(normal.normalized()) : normals[inside]);
    }
    return place->second;
  };

  // Vertices next to the cut belong to it: no cut point is made close to them, which would make
  // slivers.
  std::vector<char> on_cut(n, 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangles(f, i), triangles(f, (i + 1) % 3),
                                           [&](Index a, Index b) { return value(a) < value(b); });
      if (value(low) < 0 && value(high) >= 0 && value(high) < kSnap * (value(high) - value(low)))
        on_cut[high] = 1;
    }

  Isosurface kept;
  std::vector<std::array<Index, 3>> faces;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    std::array<Index, 4> polygon{};
    int corners = 0;
    for (int i = 0; i < 3; ++i) {
      const Index a = triangles(f, i), b = triangles(f, (i + 1) % 3);
      const bool a_in = value(a) >= 0, b_in = value(b) >= 0;
      if (a_in) polygon[corners++] = a;
      if (a_in != b_in && !on_cut[a_in ? a : b])
        polygon[corners++] = a_in ? cut_point(a, b) : cut_point(b, a);
    }
    for (int k = 2; k < corners; ++k) {
      faces.push_back({polygon[0], polygon[k - 1], polygon[k]});
      kept.source_tet.push_back(surface.source_tet[static_cast<std::size_t>(f)]);
    }
  }
  std::vector<Index> number(points.size(), -1), used;
  kept.surface.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      const Index v = faces[f][i];
      if (number[v] < 0) {
        number[v] = static_cast<Index>(used.size());
        used.push_back(v);
      }
      kept.surface.triangles(static_cast<Eigen::Index>(f), i) = number[v];
    }
  kept.surface.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
  kept.normal.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t k = 0; k < used.size(); ++k) {
    kept.surface.vertices.row(static_cast<Eigen::Index>(k)) = points[used[k]].transpose();
    kept.normal.row(static_cast<Eigen::Index>(k)) = normals[used[k]].transpose();
  }
  return kept;
}

std::vector<SurfacePart> split_components(const Isosurface& surface) {
  const Triangles& triangles = surface.surface.triangles;
  std::vector<Index> parent(static_cast<std::size_t>(surface.surface.vertices.rows()));
  std::iota(parent.begin(), parent.end(), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int i = 1; i < 3; ++i)
      parent[find_root(parent, triangles(f, i))] = find_root(parent, triangles(f, 0));

  std::vector<Index> component(parent.size(), -1);
  std::vector<std::vector<Index>> faces;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Index root = find_root(parent, triangles(f, 0));
    if (component[root] < 0) {
      component[root] = static_cast<Index>(faces.size());
      faces.emplace_back();
    }
    faces[component[root]].push_back(static_cast<Index>(f));
  }
  std::vector<Index> number(parent.size(), -1);
  std::vector<SurfacePart> parts;
  parts.reserve(faces.size());
  for (const auto& list : faces) parts.push_back(extract_triangles(surface, list, number));
  return parts;
}

SurfacePart extract_flagged(const Isosurface& surface, const std::vector<char>& flags) {
  std::vector<Index> faces, number(static_cast<std::size_t>(surface.surface.vertices.rows()), -1);
  for (std::size_t f = 0; f < flags.size(); ++f)
    if (flags[f]) faces.push_back(static_cast<Index>(f));
  return extract_triangles(surface, faces, number);
}

}  // namespace s3
