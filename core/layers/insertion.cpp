#include "layers/insertion.h"

#include <algorithm>

#include "layers/layer_parts.h"
#include "mesh/surface_edges.h"

namespace s3 {
namespace {

// Vertices on the part's surface may stand off it by the tolerance of remeshing: rays start this
// share of d_max away.
constexpr double kStart = 0.05;
// Only spans this many d_max long make a layer necessary: those that remeshing made a little too
// long are trimmed.
constexpr double kBeyond = 1.01;
// Where a layer is necessary it goes on to where the span is this many d_max: ragged pieces grow
// together.
constexpr double kEnd = 0.94;

double triangle_area(const Isosurface& surface, Eigen::Index f) {
  return triangle_normal_2a(surface.surface.vertices, surface.surface.triangles.row(f)).norm() / 2;
}

// Connected pieces of vertices that are alike.
DisjointSets pieces_of(const Triangles& triangles, const std::vector<char>& flags) {
  DisjointSets pieces(flags.size());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      const Index a = triangles(f, i), b = triangles(f, (i + 1) % 3);
      if (flags[a] == flags[b]) pieces.join(a, b);
    }
  return pieces;
}

// Where to keep the isosurface: positive on what is inserted. A piece of the zone between kEnd and
// kBeyond goes the way its surroundings go.
Values keep_value(const Isosurface& surface, const Room& room, const ThicknessRange& range) {
  const double end = std::max(2 * range.low, kEnd * range.max);
  const Eigen::Index n = room.span.size();
  Values value(n);
  std::vector<char> inside(static_cast<std::size_t>(n));
  // A layer beyond d_max cannot be printed there anyway: only what is below counts.
  const auto spare = [&](Eigen::Index v) {
    const double below = room.below(v) - range.low;
    return room.span(v) > range.high ? below : std::min(below, room.above(v) - range.low);
  };
  for (Eigen::Index v = 0; v < n; ++v) {
    value(v) = std::min(room.span(v) - end, 2 * spare(v));
    inside[static_cast<std::size_t>(v)] = value(v) > 0;
  }
  DisjointSets pieces = pieces_of(surface.surface.triangles, inside);
  std::vector<char> stays(inside.size(), 0);
  for (Eigen::Index v = 0; v < n; ++v) {
    const bool is_inside = inside[static_cast<std::size_t>(v)];
    if (is_inside ? room.span(v) > kBeyond * range.max : spare(v) < 0)
      stays[static_cast<std::size_t>(pieces.find(static_cast<Index>(v)))] = 1;
  }
  for (Eigen::Index v = 0; v < n; ++v) {
    const auto i = static_cast<std::size_t>(v);
    const bool kept =
        inside[i] == stays[static_cast<std::size_t>(pieces.find(static_cast<Index>(v)))];
    value(v) = kept ? std::max(value(v), 1e-9 * end) : std::min(value(v), -1e-9 * end);
  }
  return value;
}

Isosurface without_small_pieces(const Isosurface& surface, double least_area) {
  const Triangles& triangles = surface.surface.triangles;
  const std::vector<char> alike(static_cast<std::size_t>(surface.surface.vertices.rows()), 0);
  DisjointSets pieces = pieces_of(triangles, alike);
  std::vector<double> area(alike.size(), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    area[static_cast<std::size_t>(pieces.find(triangles(f, 0)))] += triangle_area(surface, f);
  std::vector<char> large(static_cast<std::size_t>(triangles.rows()), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    large[static_cast<std::size_t>(f)] =
        area[static_cast<std::size_t>(pieces.find(triangles(f, 0)))] >= least_area;
  return extract_flagged(surface, large).surface;
}

}  // namespace

double PartSurface::way_out(const Vec3& p, const Vec3& direction, double reach,
                            double tolerance) const {
  if (reach <= tolerance) return reach;
  const RayHit hit = tree_.first_hit(p + tolerance * direction, direction, reach - tolerance);
  if (hit.triangle < 0) return reach;
  const bool leaves =
      triangle_normal_2a(rest_.vertices, rest_.boundary_faces.row(hit.triangle)).dot(direction) > 0;
  return leaves ? tolerance + hit.t : tolerance;
}

void LayersAbove::push(const TriMesh& surface, const Values& thickness) {
  layers_.push_back({AabbTree(surface), surface.triangles, thickness});
}

LayersAbove::Nearest LayersAbove::nearest(const Vec3& p, double bound) const {
  Nearest best{bound, 0};
  for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer) {
    const Closest hit = layer->tree.closest(p, best.distance);
    if (hit.triangle < 0 || hit.distance >= best.distance) continue;
    best = {hit.distance, 0};
    for (int i = 0; i < 3; ++i)
      best.thickness += hit.barycentric(i) * layer->thickness(layer->triangles(hit.triangle, i));
  }
  return best;
}

Room measure_room(const Isosurface& surface, const Measured& distance, const LayersAbove& above,
                  const PartSurface& part, const ThicknessRange& range, Context& ctx) {
  const Points& points = surface.surface.vertices;
  const double start = kStart * range.max;
  Room room{distance.thickness, Values(points.rows()), Values(points.rows())};
  parallel_for(ctx.pool, static_cast<std::size_t>(points.rows()), 64,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = begin; i < end; ++i) {
                   const auto v = static_cast<Eigen::Index>(i);
                   const Vec3 p = points.row(v).transpose();
                   const Vec3 n = surface.normal.row(v).transpose();
                   if (room.below(v) > range.gap_reach)
                     room.below(v) = part.way_out(p, -n, room.below(v), start);
                   const LayersAbove::Nearest next = above.nearest(p, range.far());
                   room.above(v) = next.distance;
                   room.span(v) = next.thickness;
                   if (room.below(v) + next.distance <= range.max) continue;
                   const double out = part.way_out(p, n, next.distance, start);
                   if (out >= next.distance) continue;
                   room.above(v) = out;
                   room.span(v) = room.below(v) + out;
                 }
               });
  return room;
}

double area_beyond(const Isosurface& surface, const Values& span, const ThicknessRange& range) {
  double area = 0;
  for (Eigen::Index f = 0; f < surface.surface.triangles.rows(); ++f) {
    int corners = 0;
    for (int i = 0; i < 3; ++i)
      corners += span(surface.surface.triangles(f, i)) > kBeyond * range.max;
    area += corners / 3.0 * triangle_area(surface, f);
  }
  return area;
}

Isosurface insertion(const Isosurface& surface, const Room& room, const ThicknessRange& range,
                     double least_area) {
  const Values keep = keep_value(surface, room, range);
  return without_small_pieces(cut_where_negative(surface, keep), least_area);
}

}  // namespace s3
