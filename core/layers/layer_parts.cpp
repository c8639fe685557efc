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

Index find_root(std::vector<Index>& parent, Index v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

// Copies chosen triangles with the vertices they use.
Isosurface extract_triangles(const Isosurface& whole, const std::vector<Index>& faces,
                             std::vector<Index>& number) {
  Isosurface part;
  std::vector<Index> used;
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
  return part;
}

}  // namespace

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

  Isosurface kept;
  std::vector<std::array<Index, 3>> faces;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    std::array<Index, 4> polygon{};
    int corners = 0;
    for (int i = 0; i < 3; ++i) {
      const Index a = triangles(f, i), b = triangles(f, (i + 1) % 3);
      const bool a_in = value(a) >= 0, b_in = value(b) >= 0;
      if (a_in) polygon[corners++] = a;
      if (a_in != b_in) polygon[corners++] = a_in ? cut_point(a, b) : cut_point(b, a);
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

std::vector<Isosurface> split_components(const Isosurface& surface) {
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
  std::vector<Isosurface> parts;
  parts.reserve(faces.size());
  for (const auto& list : faces) parts.push_back(extract_triangles(surface, list, number));
  return parts;
}

}  // namespace s3
