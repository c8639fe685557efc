#include "picture/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace s3 {

namespace {

const Color kLine(0.02F, 0.02F, 0.03F), kViolation(0.85F, 0.05F, 0.04F);

Color kind_color(PathKind kind, double t) {
  switch (kind) {
    case PathKind::wall:
      return viridis(t);
    case PathKind::infill:
      return Color(0.80F, 0.30F, 0.05F);
    case PathKind::gap_fill:
      return Color(0.75F, 0.02F, 0.25F);
  }
  return Color::Ones();
}

// Edges of one triangle only.
std::vector<std::pair<Index, Index>> boundary_edges(const Triangles& triangles) {
  std::map<std::pair<Index, Index>, int> uses;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i)
      ++uses[std::minmax(Index(triangles(f, i)), Index(triangles(f, (i + 1) % 3)))];
  std::vector<std::pair<Index, Index>> edges;
  for (const auto& [edge, count] : uses)
    if (count == 1) edges.push_back(edge);
  return edges;
}

void quad(Rasterizer& target, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
          const Vec3& na, const Vec3& nb, const Color& color) {
  const Color colors[3] = {color, color, color};
  const Vec3 first[3] = {a, b, c}, first_normals[3] = {na, na, nb};
  const Vec3 second[3] = {a, c, d}, second_normals[3] = {na, nb, nb};
  target.triangle(first, first_normals, colors);
  target.triangle(second, second_normals, colors);
}

}  // namespace

Color viridis(double t) {
  static const std::array<Color, 6> kStops = {
      Color(0.058F, 0.0003F, 0.089F), Color(0.052F, 0.063F, 0.254F), Color(0.024F, 0.164F, 0.270F),
      Color(0.013F, 0.377F, 0.239F),  Color(0.193F, 0.640F, 0.104F), Color(0.984F, 0.799F, 0.019F)};
  const double x = std::clamp(t, 0.0, 1.0) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(x), kStops.size() - 2);
  const auto f = static_cast<float>(x - static_cast<double>(i));
  return kStops[i] * (1 - f) + kStops[i + 1] * f;
}

void draw_layers(Rasterizer& target, const LayerStack& stack, const PictureOptions& options) {
  const auto count = static_cast<double>(std::max<std::size_t>(1, stack.layers.size()));
  for (std::size_t i = 0; i < stack.layers.size(); ++i) {
    const double t = static_cast<double>(i) / count;
    if (t < options.first || t > options.last) continue;
    const Layer& layer = stack.layers[i];
    const Vec3 shift(0, 0, options.explode * static_cast<double>(layer.layer));
    const Color color = viridis(t) * (layer.layer % 2 == 0 ? 1.0F : 0.72F);
    const Color colors[3] = {color, color, color};
    for (Eigen::Index f = 0; f < layer.surface.triangles.rows(); ++f) {
      Vec3 corners[3], normals[3];
      double deepest = -1e300;
      for (int k = 0; k < 3; ++k) {
        const Index v = layer.surface.triangles(f, k);
        corners[k] = layer.surface.vertices.row(v).transpose() + shift;
        normals[k] = layer.normal.row(v);
        deepest = std::max(deepest, corners[k].y());
      }
      if (deepest > options.cut) target.triangle(corners, normals, colors);
    }
    for (const auto& [a, b] : boundary_edges(layer.surface.triangles)) {
      const Vec3 p = layer.surface.vertices.row(a).transpose() + shift,
                 q = layer.surface.vertices.row(b).transpose() + shift;
      if (std::max(p.y(), q.y()) > options.cut) target.line(p, q, kLine, 0);
    }
  }
}

void draw_toolpaths(Rasterizer& target, const Waypoints& w, const PictureOptions& options) {
  constexpr int kSides = 8;
  const double components = w.size() > 0 ? 1.0 + w.component.back() : 1.0;
  for (Index i = 1; i < w.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (w.travel[at] || w.path[at] != w.path[at - 1]) continue;
    const double t = w.component[at] / components;
    if (t < options.first || t > options.last) continue;
    const Vec3 shift(0, 0, options.explode * static_cast<double>(w.layer[at]));
    const Vec3 p = w.position.row(i - 1).transpose() + shift,
               q = w.position.row(i).transpose() + shift;
    if (std::max(p.y(), q.y()) <= options.cut || (q - p).norm() == 0) continue;
    const Color color = kind_color(w.kind[at], t) * (w.path[at] % 2 == 0 ? 1.0F : 0.85F);
    const Vec3 along = (q - p).normalized();
    std::array<std::array<Vec3, 2>, kSides> ring;  // points around p and q
    std::array<Vec3, kSides> normal;
    for (int s = 0; s < kSides; ++s) {
      const double angle = 2 * M_PI * s / kSides;
      for (int end = 0; end < 2; ++end) {
        const Index j = i - 1 + end;
        const Vec3 up = w.normal.row(j);
        const Vec3 side = along.cross(up).normalized();
        // The nozzle tip runs along the top of the bead: its middle lies half a height below.
        const Vec3 middle = (end == 0 ? p : q) - 0.5 * w.height(j) * up;
        ring[s][end] = middle + 0.5 * w.width(j) * std::cos(angle) * side +
                       0.5 * w.height(j) * std::sin(angle) * up;
        normal[s] = std::cos(angle) * side + std::sin(angle) * up;
      }
    }
    for (int s = 0; s < kSides; ++s) {
      const int n = (s + 1) % kSides;
      quad(target, ring[s][0], ring[s][1], ring[n][1], ring[n][0], normal[s], normal[n], color);
    }
  }
}

void draw_surface(Rasterizer& target, const TetMesh& mesh, const Values& field,
                  const std::vector<char>& marked) {
  const double low = field.minCoeff(), range = std::max(1e-12, field.maxCoeff() - low);
  for (Eigen::Index f = 0; f < mesh.boundary_faces.rows(); ++f) {
    const Vec3 n = triangle_normal_2a(mesh.vertices, mesh.boundary_faces.row(f)).normalized();
    Vec3 corners[3], normals[3];
    Color colors[3];
    for (int k = 0; k < 3; ++k) {
      const Index v = mesh.boundary_faces(f, k);
      corners[k] = mesh.vertices.row(v);
      normals[k] = n;
      colors[k] =
          marked[static_cast<std::size_t>(f)] ? kViolation : viridis((field(v) - low) / range);
    }
    target.triangle(corners, normals, colors);
  }
}

}  // namespace s3
