// Layers for tests of toolpaths: flat shapes on an irregular grid clipped to a level set, and bent
// ones.
#pragma once
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "layers/layer.h"

namespace s3::test {

/// Triangles of the region inside(x, y) < 0 within [lo, hi]², of edge length about h; boundary
/// vertices are moved onto the level set, so inside should be close to a signed distance.
inline Layer make_shape(const std::function<double(double, double)>& inside, double lo_x,
                        double hi_x, double lo_y, double hi_y, double h, double thickness = 0.5) {
  const int nx = static_cast<int>(std::ceil((hi_x - lo_x) / h)) + 2;
  const double row = h * std::sqrt(0.75);
  const int ny = static_cast<int>(std::ceil((hi_y - lo_y) / row)) + 2;
  std::vector<Vec3> grid;
  for (int j = -1; j <= ny; ++j)
    for (int i = -1; i <= nx; ++i)
      grid.emplace_back(lo_x + (i + (j % 2 != 0 ? 0.5 : 0.0)) * h, lo_y + j * row, 0);
  const auto id = [&](int i, int j) { return (j + 1) * (nx + 2) + i + 1; };
  std::vector<double> value;
  for (auto& p : grid) value.push_back(inside(p.x(), p.y()));
  // Vertices next to the boundary snap onto it, so that no sliver is cut.
  const auto gradient = [&](const Vec3& p) {
    const double e = 1e-4 * h;
    return Vec3((inside(p.x() + e, p.y()) - inside(p.x() - e, p.y())) / (2 * e),
                (inside(p.x(), p.y() + e) - inside(p.x(), p.y() - e)) / (2 * e), 0);
  };
  for (std::size_t v = 0; v < grid.size(); ++v)
    if (std::abs(value[v]) < 0.3 * h) {
      const Vec3 g = gradient(grid[v]);
      if (g.squaredNorm() > 0.1) {
        const Vec3 moved = grid[v] - value[v] * g / g.squaredNorm();
        if (std::abs(inside(moved.x(), moved.y())) < 1e-3 * h) grid[v] = moved, value[v] = 0;
      }
    }
  std::vector<std::array<int, 3>> faces;
  std::map<std::pair<int, int>, int> cuts;
  const auto cut = [&](int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [it, fresh] = cuts.try_emplace({a, b}, static_cast<int>(grid.size()));
    if (fresh) {
      // Bisection: exact on curved boundaries too.
      Vec3 in = value[static_cast<std::size_t>(a)] < 0 ? grid[static_cast<std::size_t>(a)]
                                                       : grid[static_cast<std::size_t>(b)];
      Vec3 out = value[static_cast<std::size_t>(a)] < 0 ? grid[static_cast<std::size_t>(b)]
                                                        : grid[static_cast<std::size_t>(a)];
      for (int k = 0; k < 50; ++k) {
        const Vec3 m = 0.5 * (in + out);
        (inside(m.x(), m.y()) < 0 ? in : out) = m;
      }
      grid.push_back(in);
      value.push_back(0);
    }
    return it->second;
  };
  const auto add = [&](int a, int b, int c) {
    const std::array<int, 3> v = {a, b, c};
    std::vector<int> polygon;
    bool any = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const int p = v[k], q = v[(k + 1) % 3];
      const double fp = value[static_cast<std::size_t>(p)], fq = value[static_cast<std::size_t>(q)];
      if (fp <= 0) polygon.push_back(p);
      any = any || fp < 0;
      if (fp * fq < 0) polygon.push_back(cut(p, q));
    }
    if (!any) return;
    for (std::size_t k = 2; k < polygon.size(); ++k)
      faces.push_back({polygon[0], polygon[k - 1], polygon[k]});
  };
  for (int j = -1; j < ny; ++j)
    for (int i = -1; i < nx; ++i) {
      if (j % 2 != 0) {
        add(id(i, j), id(i + 1, j), id(i + 1, j + 1));
        add(id(i, j), id(i + 1, j + 1), id(i, j + 1));
      } else {
        add(id(i, j), id(i + 1, j), id(i, j + 1));
        add(id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
      }
    }
  std::vector<int> number(grid.size(), -1);
  int count = 0;
  for (auto& f : faces)
    for (int& v : f) {
      if (number[static_cast<std::size_t>(v)] < 0) number[static_cast<std::size_t>(v)] = count++;
      v = number[static_cast<std::size_t>(v)];
    }
  Layer layer;
  layer.surface.vertices.resize(count, 3);
  for (std::size_t v = 0; v < grid.size(); ++v)
    if (number[v] >= 0) layer.surface.vertices.row(number[v]) = grid[v];
  layer.surface.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k)
      layer.surface.triangles(static_cast<Eigen::Index>(f), k) =
          faces[f][static_cast<std::size_t>(k)];
  layer.normal.resize(count, 3);
  layer.normal.rowwise() = Eigen::RowVector3d(0, 0, 1);
  layer.thickness.setConstant(count, thickness);
  layer.bead_height = layer.thickness;
  layer.source_tet.assign(faces.size(), 0);
  return layer;
}

inline Layer make_disc(double radius, double h) {
  return make_shape([=](double x, double y) { return std::hypot(x, y) - radius; }, -radius, radius,
                    -radius, radius, h);
}
inline Layer make_annulus(double inner, double outer, double h) {
  return make_shape(
      [=](double x, double y) {
        return std::max(std::hypot(x, y) - outer, inner - std::hypot(x, y));
      },
      -outer, outer, -outer, outer, h);
}
/// A rectangle a×b in rows of triangles that end exactly on its sides, its middle at the origin.
inline Layer make_rectangle(double a, double b, double h, double thickness = 0.5) {
  const int nx = std::max(1, static_cast<int>(std::lround(a / h))),
            ny = std::max(1, static_cast<int>(std::lround(b / h)));
  Layer layer;
  layer.surface.vertices.resize((nx + 1) * (ny + 1), 3);
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i)
      layer.surface.vertices.row(j * (nx + 1) + i) << a * i / nx - a / 2, b * j / ny - b / 2, 0;
  layer.surface.triangles.resize(2 * nx * ny, 3);
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const Index v = j * (nx + 1) + i;
      const bool flip = (i + j) % 2 != 0;
      layer.surface.triangles.row(2 * (j * nx + i)) << v, v + 1, (flip ? v + nx + 1 : v + nx + 2);
      layer.surface.triangles.row(2 * (j * nx + i) + 1) << (flip ? v + 1 : v), v + nx + 2,
          v + nx + 1;
    }
  const Eigen::Index n = layer.surface.vertices.rows();
  layer.normal.resize(n, 3);
  layer.normal.rowwise() = Eigen::RowVector3d(0, 0, 1);
  layer.thickness.setConstant(n, thickness);
  layer.bead_height = layer.thickness;
  layer.source_tet.assign(static_cast<std::size_t>(layer.surface.triangles.rows()), 0);
  return layer;
}
inline Layer make_square_with_hole(double side, double hole, double h) {
  return make_shape(
      [=](double x, double y) {
        return std::max(std::max(std::abs(x), std::abs(y)) - side / 2,
                        hole / 2 - std::max(std::abs(x), std::abs(y)));
      },
      -side / 2, side / 2, -side / 2, side / 2, h);
}
/// A disc laid on a sphere, its middle at the pole (0, 0, 0), distances from there kept.
inline Layer make_cap(double sphere_radius, double arc, double h) {
  Layer layer = make_disc(arc, h);
  for (Eigen::Index v = 0; v < layer.surface.vertices.rows(); ++v) {
    const double x = layer.surface.vertices(v, 0), y = layer.surface.vertices(v, 1),
                 s = std::hypot(x, y);
    const double angle = s / sphere_radius, c = s > 0 ? std::sin(angle) / s : 1 / sphere_radius;
    const Vec3 normal(x * c, y * c, std::cos(angle));
    layer.normal.row(v) = normal;
    layer.surface.vertices.row(v) = sphere_radius * (normal - Vec3::UnitZ());
  }
  return layer;
}
/// Two thin lobes joined by a neck.
inline Layer make_lobes(double h) {
  return make_shape(
      [](double x, double y) {
        const double lobe = std::hypot((std::abs(x) - 9) / 1.6, y) - 4;
        const double neck = std::max(std::abs(y) - 0.6 - 0.03 * x * x, std::abs(x) - 9);
        return std::min(lobe, neck);
      },
      -16, 16, -5, 5, h);
}

}  // namespace s3::test
