// Adaptive slicing (Sec. 4.2, Steps 1-3).
#include "layers/adaptive_slicing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

#include "layers/isosurface.h"
#include "layers/layer_distance.h"

namespace s3 {
namespace {

std::string mm(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " mm";
}

void check_range(const LayerParams& params) {
  // Rims that overhang by 45° are √2 thicker than the layer: a ratio below that leaves no valid
  // thickness there.
  constexpr double kMinRatio = 1.5;
  if (params.d_min() > 0 && params.d_max() >= kMinRatio * params.d_min() * (1 - 1e-12)) return;
  throw Error(ErrorKind::input, Stage::layers, "layers.bad_range",
              "Layers between " + mm(params.d_min()) + " and " + mm(params.d_max()) +
                  " thick cannot be made: the thickest must be at least 1.5 times the thinnest.",
              "Change layers.min_thickness or layers.max_thickness; 0.4 and 1.0 nozzle diameters "
              "are usual.");
}

Index find_root(std::vector<Index>& parent, Index v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

// Cuts a surface into its connected components, in the order of their first triangle.
std::vector<Layer> split_components(const Layer& whole) {
  const Triangles& triangles = whole.surface.triangles;
  std::vector<Index> parent(static_cast<std::size_t>(whole.surface.vertices.rows()));
  std::iota(parent.begin(), parent.end(), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int i = 1; i < 3; ++i)
      parent[find_root(parent, triangles(f, i))] = find_root(parent, triangles(f, 0));

  std::vector<Index> component(parent.size(), -1), local(parent.size(), -1);
  std::vector<std::vector<Index>> faces, vertices;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Index root = find_root(parent, triangles(f, 0));
    if (component[root] < 0) {
      component[root] = static_cast<Index>(faces.size());
      faces.emplace_back();
      vertices.emplace_back();
    }
    const Index c = component[root];
    faces[c].push_back(static_cast<Index>(f));
    for (int i = 0; i < 3; ++i) {
      const Index v = triangles(f, i);
      if (local[v] >= 0) continue;
      local[v] = static_cast<Index>(vertices[c].size());
      vertices[c].push_back(v);
    }
  }

  std::vector<Layer> parts(faces.size());
  for (std::size_t c = 0; c < parts.size(); ++c) {
    Layer& part = parts[c];
    part.iso_value = whole.iso_value;
    part.layer = whole.layer;
    part.partial = whole.partial;
    const auto n = static_cast<Eigen::Index>(vertices[c].size());
    part.surface.vertices.resize(n, 3);
    part.normal.resize(n, 3);
    part.thickness.resize(n);
    for (Eigen::Index v = 0; v < n; ++v) {
      part.surface.vertices.row(v) = whole.surface.vertices.row(vertices[c][v]);
      part.normal.row(v) = whole.normal.row(vertices[c][v]);
      part.thickness(v) = whole.thickness(vertices[c][v]);
    }
    part.surface.triangles.resize(static_cast<Eigen::Index>(faces[c].size()), 3);
    part.source_tet.reserve(faces[c].size());
    for (std::size_t f = 0; f < faces[c].size(); ++f) {
      for (int i = 0; i < 3; ++i)
        part.surface.triangles(static_cast<Eigen::Index>(f), i) = local[triangles(faces[c][f], i)];
      part.source_tet.push_back(whole.source_tet[faces[c][f]]);
    }
  }
  return parts;
}

Values measure(const Points& points, const PrintedMaterial& material, double bound, Context& ctx) {
  Values thickness(points.rows());
  parallel_for(ctx.pool, static_cast<std::size_t>(points.rows()), 256,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v)
                   thickness(static_cast<Eigen::Index>(v)) = material.distance(
                       points.row(static_cast<Eigen::Index>(v)).transpose(), bound);
               });
  return thickness;
}

LayerStack slice_evenly(const TetMesh& rest, const ScalarField& field, double step, Context& ctx) {
  LayerStack stack;
  IsosurfaceExtractor extractor(rest, field);
  PrintedMaterial material;
  const auto count = static_cast<Index>(
      std::floor((extractor.max_value() - extractor.min_value()) / step * (1 + 1e-9)));
  for (Index i = 0; i < count; ++i) {
    ctx.progress(Stage::layers, double(i) / count);
    Isosurface iso = extractor.extract(extractor.min_value() + (i + 1) * step);
    if (iso.surface.triangles.rows() == 0) continue;
    Layer whole;
    whole.thickness = measure(iso.surface.vertices, material, 10 * step, ctx);
    whole.surface = std::move(iso.surface);
    whole.normal = std::move(iso.normal);
    whole.source_tet = std::move(iso.source_tet);
    whole.iso_value = extractor.min_value() + (i + 1) * step;
    whole.layer = stack.isosurfaces++;
    material.add(whole.surface);
    for (Layer& part : split_components(whole)) stack.layers.push_back(std::move(part));
  }
  ctx.progress(Stage::layers, 1);
  return stack;
}

}  // namespace

LayerStack make_layers(const TetMesh& rest, const ScalarField& field, const LayerParams& params,
                       Context& ctx) {
  check_range(params);
  return slice_evenly(rest, field, 0.5 * (params.d_min() + params.d_max()), ctx);
}

LayerStack make_planar_layers(const TetMesh& rest, double layer_height, const LayerParams& params,
                              Context& ctx) {
  check_range(params);
  return slice_evenly(rest, make_scalar_field(rest, rest.vertices.col(2)), layer_height, ctx);
}

}  // namespace s3
