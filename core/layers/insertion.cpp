#include "layers/insertion.h"

#include <algorithm>

#include "layers/layer_parts.h"
#include "mesh/surface_edges.h"

namespace s3 {
namespace {

// Vertices may stand off the part's surface by the tolerance of remeshing: this share of d_max.
constexpr double kTolerance = 0.05;
// Only spans this many d_max long make a layer necessary: those that remeshing made a little too
// long are trimmed.
constexpr double kBeyond = 1.01;
// Where a layer is necessary it goes on to where the span is this many d_max: ragged pieces grow
// together.
constexpr double kEnd = 0.94;

// A face is a top where its normal is within 30° of ∇G.
constexpr double kTopCosine = 0.87;

double triangle_area(const Isosurface& surface, Eigen::Index f) {
  return triangle_normal_2a(surface.surface.vertices, surface.surface.triangles.row(f)).norm() / 2;
}

// The vertices, moved a little towards the triangles around them: rays from the surface's boundary
// would run along the part's walls otherwise.
Points inner_points(const TriMesh& surface) {
  constexpr double kInwards = 0.1;
  Points sum = Points::Zero(surface.vertices.rows(), 3);
  Values count = Values::Zero(surface.vertices.rows());
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corners = surface.triangles.row(f);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) sum.row(corners(i)) += surface.vertices.row(corners(j)) / 3;
      count(corners(i)) += 1;
    }
  }
  Points inner = surface.vertices;
  for (Eigen::Index v = 0; v < inner.rows(); ++v)
    if (count(v) > 0) inner.row(v) += kInwards * (sum.row(v) / count(v) - inner.row(v));
  return inner;
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

PartSurface::Exit PartSurface::leave(const Vec3& p, const Vec3& direction, double reach,
                                     double tolerance) const {
  const Vec3 from = p - tolerance * direction;
  for (const RayHit& hit : tree_.all_hits(from, direction, reach + tolerance)) {
    const auto corners = rest_.boundary_faces.row(hit.triangle);
    const double cosine = triangle_normal_2a(rest_.vertices, corners).normalized().dot(direction);
    if (cosine > 0) return {std::max(hit.t - tolerance, 0.0), cosine};
  }
  return {reach, 0};
}

Tops::Tops(const TetMesh& rest, const ScalarField& field) {
  for (Eigen::Index f = 0; f < rest.boundary_faces.rows(); ++f) {
    const auto corners = rest.boundary_faces.row(f);
    const Vec3 normal_2a = triangle_normal_2a(rest.vertices, corners);
    const Index t = rest.boundary_face_tet[static_cast<std::size_t>(f)];
    const Vec3 gradient = field.gradient.row(t).transpose();
    if (normal_2a.dot(gradient) <= kTopCosine * normal_2a.norm() * gradient.norm()) continue;
    const double value =
        (field.value(corners(0)) + field.value(corners(1)) + field.value(corners(2))) / 3;
    faces_.push_back({value, gradient.norm(), normal_2a.norm() / 2});
  }
  std::sort(faces_.begin(), faces_.end(),
            [](const Face& a, const Face& b) { return a.value < b.value; });
}

// A flat top has one value of G: a layer lies this share of its height below it.
constexpr double kBelowTop = 1e-3;

// A layer at g fills (g − from)/‖∇G‖ below each face from g on, as far as it is not too thin.
Tops::Choice Tops::between(double from, double to, double least) const {
  const auto by_value = [](const Face& face, double value) { return face.value < value; };
  const auto begin = std::lower_bound(faces_.begin(), faces_.end(), from, by_value);
  const auto end = std::lower_bound(begin, faces_.end(), to, by_value);
  std::vector<std::pair<double, double>> events;  // from which g on a face adds its area/‖∇G‖
  for (auto face = begin; face != end; ++face) {
    const double first = from + least * face->slope;
    if (first >= face->value) continue;
    events.emplace_back(first, face->area / face->slope);
    events.emplace_back(face->value, -face->area / face->slope);
  }
  std::sort(events.begin(), events.end());
  Choice best;
  double weight = 0;
  for (const auto& [value, change] : events) {
    if (change < 0 && weight * (value - from) > best.volume)
      best = {value - kBelowTop * (value - from), weight * (value - from)};
    weight += change;
  }
  return best;
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
  const Points points = inner_points(surface.surface);
  const double tolerance = kTolerance * range.max;
  Room room{distance.thickness, Values(points.rows()), Values(points.rows())};
  parallel_for(ctx.pool, static_cast<std::size_t>(points.rows()), 64,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = begin; i < end; ++i) {
                   const auto v = static_cast<Eigen::Index>(i);
                   const Vec3 p = points.row(v).transpose();
                   const Vec3 n = surface.normal.row(v).transpose();
                   if (room.below(v) > range.gap_reach)
                     room.below(v) = part.leave(p, -n, room.below(v), tolerance).distance;
                   const LayersAbove::Nearest next = above.nearest(p, range.far());
                   room.above(v) = next.distance;
                   room.span(v) = next.thickness;
                   if (room.below(v) + next.distance <= range.max) continue;
                   const double out = part.leave(p, n, next.distance, tolerance).distance;
                   if (out >= next.distance) continue;
                   room.above(v) = range.far();
                   room.span(v) = std::max(room.below(v) + out, next.thickness);
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

Isosurface below_tops(const Isosurface& surface, const Measured& distance, const LayersAbove& above,
                      const PartSurface& part, const ThicknessRange& range, double least_area,
                      Context& ctx) {
  const Points points = inner_points(surface.surface);
  const double tolerance = kTolerance * range.max;
  Values keep(points.rows());
  parallel_for(ctx.pool, static_cast<std::size_t>(points.rows()), 64,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = begin; i < end; ++i) {
                   const auto v = static_cast<Eigen::Index>(i);
                   const Vec3 p = points.row(v).transpose();
                   const double next = above.nearest(p, range.far()).distance;
                   const auto out =
                       part.leave(p, surface.normal.row(v).transpose(), next, tolerance);
                   const bool top = out.cosine > kTopCosine;
                   keep(v) = std::min({distance.thickness(v) - range.low, next - range.low,
                                       top ? next - out.distance : -range.low});
                 }
               });
  return without_small_pieces(cut_where_negative(surface, keep), least_area);
}

Isosurface insertion(const Isosurface& surface, const Room& room, const ThicknessRange& range,
                     double least_area) {
  const Values keep = keep_value(surface, room, range);
  return without_small_pieces(cut_where_negative(surface, keep), least_area);
}

}  // namespace s3
