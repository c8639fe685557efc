#include "layers/trim_to_range.h"

#include <algorithm>
#include <array>
#include <limits>

#include "layers/layer_parts.h"

namespace s3 {
namespace {

constexpr int kRefinements = 3;
// Above smooth material too, the thickness between vertices differs from theirs, by up to this
// share of the range.
constexpr double kNear = 0.15;
constexpr int kCutRounds = 3;
// Triangles that are partly outside are split this often before they are taken away.
constexpr int kClipRounds = 4;
// A slight excess is up to this many d_max, and not within that many of a gap.
constexpr double kSlight = 1.12;
constexpr double kGapRadius = 1.5;

class Trimmer {
 public:
  Trimmer(const PrintedMaterial& material, const ThicknessRange& range, Isosurface& surface,
          Measured& distance, Context& ctx)
      : material_(material), range_(range), surface_(surface), distance_(distance), ctx_(ctx) {}

  Trimmed trim();

 private:
  struct Samples {
    SurfaceEdges edges;
    Values edge;               // #E at the midpoints
    Values centroid;           // #F
    std::vector<Index> below;  // #E + #F: the components nearest to them
  };

  bool cut();
  double thickest(const SurfacePart& piece) const;
  bool mark_beyond(Values& keep);
  void flag_in_air();
  void clip();
  Samples sample(Index first_new) const;
  void remove(const std::vector<char>& keep, std::vector<Index>& mixed);
  void split(const std::vector<Index>& faces);
  void add_carriers(const std::vector<Index>& below);
  void note_left_out(const std::vector<char>& beyond);
  void measure_all() {
    distance_ = measure(material_, surface_.surface.vertices, range_.far(), ctx_);
  }
  bool is_outside(double thickness, bool in_air) const {
    return thickness < range_.min || (thickness > range_.max && !in_air);
  }

  const PrintedMaterial& material_;
  const ThicknessRange& range_;
  Isosurface& surface_;
  Measured& distance_;
  Context& ctx_;
  std::vector<char> in_air_;  // #V: of a piece that starts in the air
  Trimmed trimmed_;
};

double triangle_area(const Isosurface& surface, Eigen::Index f) {
  return triangle_normal_2a(surface.surface.vertices, surface.surface.triangles.row(f)).norm() / 2;
}

// Connected pieces of the triangles with a flag; vertices as numbered in the whole.
std::vector<SurfacePart> flagged_pieces(const Isosurface& surface, const std::vector<char>& flags) {
  const SurfacePart kept = extract_flagged(surface, flags);
  std::vector<SurfacePart> pieces = split_components(kept.surface);
  for (SurfacePart& piece : pieces)
    for (Index& v : piece.vertices) v = kept.vertices[v];
  return pieces;
}

// Connected pieces of triangles with a corner thicker than `limit`.
std::vector<SurfacePart> pieces_beyond(const Isosurface& surface, const Values& thickness,
                                       double limit) {
  const Triangles& triangles = surface.surface.triangles;
  std::vector<char> beyond(static_cast<std::size_t>(triangles.rows()), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i)
      beyond[static_cast<std::size_t>(f)] |= thickness(triangles(f, i)) > limit;
  return flagged_pieces(surface, beyond);
}

Trimmed Trimmer::trim() {
  for (int round = 0; round < kCutRounds && distance_.thickness.size() > 0; ++round)
    if (!cut()) break;
  if (distance_.thickness.size() > 0) clip();
  return std::move(trimmed_);
}

// One round of cutting along the limits, as interpolated between vertices.
// @return whether something was cut
bool Trimmer::cut() {
  const double reserve = range_.low - range_.min;
  const double low = range_.min + 0.25 * reserve, high = range_.max - 0.25 * reserve;
  refine_extremes(material_, range_, low, high, surface_, distance_, ctx_);
  Values keep = Values::Constant(distance_.thickness.size(), 1);
  if (distance_.thickness.minCoeff() < low)
    keep = distance_.thickness.array() - (low + 0.25 * reserve);
  const bool carried = mark_beyond(keep);
  if (carried && keep.minCoeff() >= 0) return false;
  surface_ = cut_where_negative(surface_, keep);
  measure_all();
  return true;
}

double Trimmer::thickest(const SurfacePart& piece) const {
  double thickest = 0;
  for (const Index v : piece.vertices) thickest = std::max(thickest, distance_.thickness(v));
  return thickest;
}

// Sets `keep` negative on connected pieces beyond the range that the next layers can close.
// @return whether there was nothing to mark
bool Trimmer::mark_beyond(Values& keep) {
  const double high = range_.max - 0.25 * (range_.low - range_.min);
  const Values& thickness = distance_.thickness;
  if (thickness.maxCoeff() <= high) return true;
  bool none = true;
  for (const SurfacePart& piece : pieces_beyond(surface_, thickness, high)) {
    if (thickest(piece) > range_.gap_reach) continue;
    none = false;
    double area = 0;
    for (Eigen::Index f = 0; f < piece.surface.surface.triangles.rows(); ++f) {
      int corners = 0;
      for (int i = 0; i < 3; ++i)
        corners += thickness(piece.vertices[piece.surface.surface.triangles(f, i)]) > high;
      area += corners / 3.0 * triangle_area(piece.surface, f);
    }
    for (const Index v : piece.vertices) keep(v) = std::min(keep(v), high - thickness(v));
    trimmed_.left_out_area += area;
    trimmed_.left_out_places.push_back(piece.surface.surface.vertices.colwise().mean().transpose());
  }
  return none;
}

// Flags the pieces that stay although they start in the air.
void Trimmer::flag_in_air() {
  in_air_.assign(static_cast<std::size_t>(distance_.thickness.size()), 0);
  if (distance_.thickness.maxCoeff() <= range_.gap_reach) return;
  for (const SurfacePart& piece : pieces_beyond(surface_, distance_.thickness, range_.max))
    if (thickest(piece) > range_.gap_reach)
      for (const Index v : piece.vertices) in_air_[v] = 1;
}

// Thickness between the vertices, of triangles with a vertex from `first_new` on.
Trimmer::Samples Trimmer::sample(Index first_new) const {
  const Triangles& triangles = surface_.surface.triangles;
  const Points& points = surface_.surface.vertices;
  Samples samples{SurfaceEdges(triangles, static_cast<Index>(points.rows())), {}, {}, {}};
  const SurfaceEdges& edges = samples.edges;
  samples.edge = Values::Zero(edges.ends.rows());
  samples.centroid = Values::Zero(triangles.rows());
  samples.below.assign(static_cast<std::size_t>(edges.ends.rows() + triangles.rows()),
                       PrintedMaterial::kPlate);
  std::vector<char> wanted(static_cast<std::size_t>(triangles.rows()), 0);
  std::vector<char> wanted_edge(static_cast<std::size_t>(edges.ends.rows()), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    if (triangles.row(f).maxCoeff() >= first_new) {
      wanted[static_cast<std::size_t>(f)] = 1;
      for (int i = 0; i < 3; ++i) wanted_edge[edges.of_triangle(f, i)] = 1;
    }
  const Values& at = distance_.thickness;
  // The distance changes by at most the way: a bound for each search.
  const auto search = [&](const Vec3& p, std::initializer_list<Index> corners) {
    double bound = range_.far();
    for (const Index v : corners)
      bound = std::min(bound, (at(v) + (points.row(v).transpose() - p).norm()) * (1 + 1e-9));
    return material_.nearest(p, bound + 1e-9 * range_.max);
  };
  parallel_for(ctx_.pool, wanted_edge.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      if (!wanted_edge[e]) continue;
      const auto row = static_cast<Eigen::Index>(e);
      const Index a = edges.ends(row, 0), b = edges.ends(row, 1);
      const auto nearest = search(0.5 * (points.row(a) + points.row(b)).transpose(), {a, b});
      samples.edge(row) = nearest.distance;
      samples.below[e] = nearest.id;
    }
  });
  parallel_for(ctx_.pool, wanted.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      if (!wanted[f]) continue;
      const auto row = static_cast<Eigen::Index>(f);
      const Index a = triangles(row, 0), b = triangles(row, 1), c = triangles(row, 2);
      const auto nearest =
          search((points.row(a) + points.row(b) + points.row(c)).transpose() / 3, {a, b, c});
      samples.centroid(row) = nearest.distance;
      samples.below[wanted_edge.size() + f] = nearest.id;
    }
  });
  return samples;
}

// The last word: triangles that are outside at a corner, an edge's midpoint or the centroid are
// taken away; those that are so in part only are split first, as long as that saves area.
void Trimmer::clip() {
  flag_in_air();
  Index first_new = 0;
  for (int round = 0; round <= kClipRounds; ++round) {
    const Triangles& triangles = surface_.surface.triangles;
    const Samples samples = sample(first_new);
    add_carriers(samples.below);
    std::vector<char> keep(static_cast<std::size_t>(triangles.rows()), 1);
    std::vector<char> beyond(keep.size(), 0);
    std::vector<Index> mixed;
    for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
      if (triangles.row(f).maxCoeff() < first_new) continue;
      bool in_air = false;
      for (int i = 0; i < 3; ++i) in_air = in_air || in_air_[triangles(f, i)];
      std::array<double, 7> thickness{};
      for (int i = 0; i < 3; ++i) {
        thickness[i] = distance_.thickness(triangles(f, i));
        thickness[3 + i] = samples.edge(samples.edges.of_triangle(f, i));
      }
      thickness[6] = samples.centroid(f);
      const auto outside = std::count_if(thickness.begin(), thickness.end(),
                                         [&](double t) { return is_outside(t, in_air); });
      if (outside == 0) continue;
      if (outside < 7 && round < kClipRounds) {
        mixed.push_back(static_cast<Index>(f));
      } else {
        keep[static_cast<std::size_t>(f)] = 0;
        beyond[static_cast<std::size_t>(f)] =
            *std::max_element(thickness.begin(), thickness.end()) > range_.max;
      }
    }
    note_left_out(beyond);
    if (std::count(keep.begin(), keep.end(), 0) > 0) remove(keep, mixed);
    if (mixed.empty()) return;
    first_new = static_cast<Index>(surface_.surface.vertices.rows());
    split(mixed);
  }
}

void Trimmer::add_carriers(const std::vector<Index>& below) {
  std::vector<Index>& all = trimmed_.carriers;
  all.insert(all.end(), below.begin(), below.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  if (!all.empty() && all.front() == PrintedMaterial::kPlate) all.erase(all.begin());
}

void Trimmer::note_left_out(const std::vector<char>& beyond) {
  for (const SurfacePart& piece : flagged_pieces(surface_, beyond)) {
    trimmed_.left_out_area += surface_area(piece.surface.surface);
    trimmed_.left_out_places.push_back(piece.surface.surface.vertices.colwise().mean().transpose());
  }
}

// Takes triangles away; `mixed` follows the new numbers.
void Trimmer::remove(const std::vector<char>& keep, std::vector<Index>& mixed) {
  std::vector<Index> number(keep.size(), -1);
  Index next = 0;
  for (std::size_t f = 0; f < keep.size(); ++f)
    if (keep[f]) number[f] = next++;
  for (Index& f : mixed) f = number[f];
  SurfacePart rest = extract_flagged(surface_, keep);
  Measured distance;
  std::vector<char> in_air;
  distance.thickness.resize(static_cast<Eigen::Index>(rest.vertices.size()));
  for (std::size_t v = 0; v < rest.vertices.size(); ++v) {
    const Index old = rest.vertices[v];
    distance.thickness(static_cast<Eigen::Index>(v)) = distance_.thickness(old);
    distance.below.push_back(distance_.below[old]);
    distance.on_rim.push_back(distance_.on_rim[old]);
    in_air.push_back(in_air_[old]);
  }
  surface_ = std::move(rest.surface);
  distance_ = std::move(distance);
  in_air_ = std::move(in_air);
}

void Trimmer::split(const std::vector<Index>& faces) {
  const Index vertices = static_cast<Index>(surface_.surface.vertices.rows());
  const SurfaceEdges edges(surface_.surface.triangles, vertices);
  std::vector<char> marked(static_cast<std::size_t>(edges.ends.rows()), 0);
  for (const Index f : faces)
    for (int i = 0; i < 3; ++i) marked[edges.of_triangle(f, i)] = 1;
  for (std::size_t e = 0; e < marked.size(); ++e)
    if (marked[e]) {
      const auto ends = edges.ends.row(static_cast<Eigen::Index>(e));
      in_air_.push_back(in_air_[ends(0)] && in_air_[ends(1)]);
    }
  surface_ = split_edges(surface_, edges, marked);
  const Measured added = measure(
      material_, surface_.surface.vertices.bottomRows(surface_.surface.vertices.rows() - vertices),
      range_.far(), ctx_);
  distance_.thickness.conservativeResize(surface_.surface.vertices.rows());
  distance_.thickness.tail(added.thickness.size()) = added.thickness;
  distance_.below.insert(distance_.below.end(), added.below.begin(), added.below.end());
  distance_.on_rim.insert(distance_.on_rim.end(), added.on_rim.begin(), added.on_rim.end());
}

}  // namespace

Measured measure(const PrintedMaterial& material, const Points& points, double far, Context& ctx) {
  Measured result;
  result.thickness.resize(points.rows());
  result.below.resize(static_cast<std::size_t>(points.rows()));
  result.on_rim.resize(result.below.size());
  parallel_for(ctx.pool, result.below.size(), 256, [&](std::size_t begin, std::size_t end) {
    double bound = far;
    for (std::size_t v = begin; v < end; ++v) {
      const auto row = static_cast<Eigen::Index>(v);
      // The distance changes by at most the way from the vertex before, which is often near.
      if (v > begin)
        bound = std::min(
            far, (result.thickness(row - 1) + (points.row(row) - points.row(row - 1)).norm()) *
                         (1 + 1e-9) +
                     1e-9 * far);
      const auto nearest = material.nearest(points.row(row).transpose(), bound);
      result.thickness(row) = nearest.distance;
      result.below[v] = nearest.id;
      result.on_rim[v] = nearest.on_rim;
    }
  });
  return result;
}

void refine_extremes(const PrintedMaterial& material, const ThicknessRange& range, double low,
                     double high, Isosurface& surface, Measured& distance, Context& ctx) {
  const double noticeable = 0.2 * (range.low - range.min), near = kNear * (range.max - range.min);
  Index first_new = 0;  // later rounds look at edges of new vertices only
  for (int round = 0; round < kRefinements; ++round) {
    const SurfaceEdges edges(surface.surface.triangles, static_cast<Index>(distance.below.size()));
    const Points& points = surface.surface.vertices;
    std::vector<Index> suspects;
    for (Index e = 0; e < static_cast<Index>(edges.ends.rows()); ++e) {
      const Index a = edges.ends(e, 0), b = edges.ends(e, 1);
      if (std::max(a, b) < first_new) continue;
      const auto [least, most] = std::minmax(distance.thickness(a), distance.thickness(b));
      const bool smooth =
          distance.below[a] == distance.below[b] && !distance.on_rim[a] && !distance.on_rim[b];
      if (smooth && least > low + near && most < high - near) continue;
      // The distance changes by at most the way: elsewhere the midpoint cannot be outside.
      const double mean = 0.5 * (distance.thickness(a) + distance.thickness(b));
      const double half = 0.5 * (points.row(a) - points.row(b)).norm();
      const bool inside = most <= high;
      if ((most >= low && mean - half < low) || (inside && mean + half > high))
        suspects.push_back(e);
    }
    Points middles(static_cast<Eigen::Index>(suspects.size()), 3);
    for (std::size_t k = 0; k < suspects.size(); ++k)
      middles.row(static_cast<Eigen::Index>(k)) =
          0.5 * (points.row(edges.ends(suspects[k], 0)) + points.row(edges.ends(suspects[k], 1)));
    const Measured middle = measure(material, middles, range.far(), ctx);
    std::vector<char> marked(static_cast<std::size_t>(edges.ends.rows()), 0);
    std::vector<double> added;
    for (std::size_t k = 0; k < suspects.size(); ++k) {
      const double at_middle = middle.thickness(static_cast<Eigen::Index>(k));
      const double expected = 0.5 * (distance.thickness(edges.ends(suspects[k], 0)) +
                                     distance.thickness(edges.ends(suspects[k], 1)));
      const bool valley = at_middle < low && at_middle < expected - noticeable;
      const bool ridge = at_middle > high && at_middle > expected + noticeable;
      if (!valley && !ridge) continue;
      marked[suspects[k]] = 1;
      added.push_back(at_middle);
      distance.below.push_back(middle.below[k]);
      distance.on_rim.push_back(middle.on_rim[k]);
    }
    if (added.empty()) return;
    const Eigen::Index before = distance.thickness.size();
    first_new = static_cast<Index>(before);
    distance.thickness.conservativeResize(before + static_cast<Eigen::Index>(added.size()));
    for (std::size_t k = 0; k < added.size(); ++k)
      distance.thickness(before + static_cast<Eigen::Index>(k)) = added[k];
    surface = split_edges(surface, edges, marked);
  }
}

double slight_excess(const ThicknessRange& range, const Isosurface& surface,
                     const Measured& distance, const std::vector<Vec3>& gaps) {
  const Values& thickness = distance.thickness;
  if (thickness.size() == 0 || thickness.maxCoeff() <= range.max) return 0;
  double excess = 0;
  for (const SurfacePart& piece : pieces_beyond(surface, thickness, range.max)) {
    double thickest = 0;
    bool at_gap = false;
    for (const Index v : piece.vertices) {
      thickest = std::max(thickest, thickness(v));
      const Vec3 p = surface.surface.vertices.row(v).transpose();
      at_gap = at_gap || std::any_of(gaps.begin(), gaps.end(), [&](const Vec3& gap) {
                 return (p - gap).norm() < kGapRadius * range.max;
               });
    }
    if (!at_gap && thickest <= kSlight * range.max) excess = std::max(excess, thickest);
  }
  return excess;
}

Trimmed trim_to_range(const PrintedMaterial& material, const ThicknessRange& range,
                      Isosurface& surface, Measured& distance, Context& ctx) {
  return Trimmer(material, range, surface, distance, ctx).trim();
}

}  // namespace s3
