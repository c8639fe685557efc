#include "layers/layer_distance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "layers/layer_parts.h"

namespace s3 {
namespace {

constexpr std::size_t kGroup = 16;

double box_distance(const Box& box, const Vec3& p) {
  return (box.min - p).cwiseMax(p - box.max).cwiseMax(0.0).norm();
}

Box segment_box(const Vec3& a, const Vec3& b) {
  return {a.cwiseMin(b), a.cwiseMax(b)};
}

bool boxes_meet(const Box& a, const Box& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

struct Sample {
  double thickness, area;
};

double quantile(const std::vector<Sample>& sorted, double total, double share) {
  double sum = 0;
  for (const Sample& sample : sorted) {
    sum += sample.area;
    if (sum >= share * total) return sample.thickness;
  }
  return sorted.back().thickness;
}

}  // namespace

void PrintedMaterial::add(const TriMesh& surface, Index id) {
  const SurfaceEdges edges(surface.triangles, static_cast<Index>(surface.vertices.rows()));
  std::vector<char> uses(static_cast<std::size_t>(edges.ends.rows()), 0);
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) ++uses[edges.of_triangle(f, i)];
  std::vector<char> on_rim(static_cast<std::size_t>(surface.vertices.rows()), 0);
  for (std::size_t e = 0; e < uses.size(); ++e)
    if (uses[e] == 1)
      for (int i = 0; i < 2; ++i) on_rim[edges.ends(static_cast<Eigen::Index>(e), i)] = 1;
  const Box box = bounding_box(surface.vertices);
  if (parts_.size() % kGroup == 0) group_boxes_.push_back(box);
  Box& group = group_boxes_.back();
  group.min = group.min.cwiseMin(box.min);
  group.max = group.max.cwiseMax(box.max);
  parts_.push_back({AabbTree(surface), box, id, surface.triangles, std::move(on_rim)});
}

PrintedMaterial::Nearest PrintedMaterial::nearest(const Vec3& p, double bound) const {
  Nearest best{std::min(bound, std::max(p.z(), 0.0)), kPlate, false};
  Closest closest;
  const Part* at = nullptr;
  // The newest first: it is usually the nearest, and its distance rules out all others by their
  // boxes.
  for (std::size_t group = group_boxes_.size(); group-- > 0;) {
    if (box_distance(group_boxes_[group], p) >= best.distance) continue;
    for (std::size_t k = std::min(parts_.size(), (group + 1) * kGroup); k-- > group * kGroup;) {
      const Part& part = parts_[k];
      if (box_distance(part.box, p) >= best.distance) continue;
      const Closest hit = part.tree.closest(p, best.distance);
      if (hit.triangle < 0 || hit.distance >= best.distance) continue;
      best.distance = hit.distance;
      best.id = part.id;
      closest = hit;
      at = &part;
    }
  }
  if (at) {
    best.on_rim = true;
    for (int i = 0; i < 3; ++i)
      if (closest.barycentric(i) > 0 && !at->on_rim[at->triangles(closest.triangle, i)])
        best.on_rim = false;
  }
  return best;
}

double PrintedMaterial::along(const Vec3& p, const Vec3& direction, double reach) const {
  double way = reach;
  if (direction.z() < 0) way = std::clamp(-p.z() / direction.z(), 0.0, reach);
  Box box = segment_box(p, p + way * direction);
  for (std::size_t group = group_boxes_.size(); group-- > 0;) {
    if (!boxes_meet(group_boxes_[group], box)) continue;
    for (std::size_t k = std::min(parts_.size(), (group + 1) * kGroup); k-- > group * kGroup;) {
      if (!boxes_meet(parts_[k].box, box)) continue;
      const RayHit hit = parts_[k].tree.first_hit(p, direction, way);
      if (hit.triangle < 0 || hit.t >= way) continue;
      way = hit.t;
      box = segment_box(p, p + way * direction);
    }
  }
  return way;
}

ThicknessReport measure_thickness(const LayerStack& stack, double d_min, double d_max,
                                  Context& ctx) {
  ThicknessReport report;
  PrintedMaterial material;
  std::vector<Sample> samples;
  const double far = 100 * d_max;
  std::size_t first = 0;
  while (first < stack.layers.size()) {
    std::size_t last = first;  // components of one isosurface do not carry each other
    while (last < stack.layers.size() && stack.layers[last].layer == stack.layers[first].layer)
      ++last;
    for (std::size_t c = first; c < last; ++c) {
      ctx.checkpoint();
      const TriMesh& surface = stack.layers[c].surface;
      const auto faces = static_cast<std::size_t>(surface.triangles.rows());
      const std::size_t offset = samples.size();
      samples.resize(offset + 7 * faces);
      parallel_for(ctx.pool, faces, 128, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          const auto row = surface.triangles.row(static_cast<Eigen::Index>(f));
          const Vec3 a = surface.vertices.row(row(0)), b = surface.vertices.row(row(1)),
                     d = surface.vertices.row(row(2));
          const std::array<Vec3, 7> points = {
              a, b, d, 0.5 * (a + b), 0.5 * (b + d), 0.5 * (d + a), (a + b + d) / 3.0};
          const double area = triangle_normal_2a(surface.vertices, row).norm() / 2;
          for (std::size_t k = 0; k < points.size(); ++k)
            samples[offset + 7 * f + k] = {material.nearest(points[k], far).distance, area / 7};
        }
      });
    }
    for (std::size_t c = first; c < last; ++c)
      material.add(stack.layers[c].surface, static_cast<Index>(c));
    first = last;
  }
  for (const Sample& sample : samples) {
    report.area += sample.area;
    if (sample.thickness < d_min) report.thin_area += sample.area;
    if (sample.thickness > d_max) report.thick_area += sample.area;
  }
  if (!(report.area > 0)) return report;
  parallel_sort(ctx.pool, samples, [](const Sample& a, const Sample& b) {
    return a.thickness != b.thickness ? a.thickness < b.thickness : a.area < b.area;
  });
  report.min = samples.front().thickness;
  report.max = samples.back().thickness;
  report.p1 = quantile(samples, report.area, 0.01);
  report.p50 = quantile(samples, report.area, 0.5);
  report.p99 = quantile(samples, report.area, 0.99);
  return report;
}

}  // namespace s3
