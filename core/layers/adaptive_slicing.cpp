// Adaptive slicing (Sec. 4.2). The paper spaces complete isosurfaces at d_min, halves gaps beyond
// d_max and removes what is then thinner than d_min. Here the same three steps are one sweep over
// the printed material. The next complete isosurface is the highest whose distance to the material
// stays below d_max everywhere or, where that would be too thin elsewhere, the lowest that is not.
// Where it is farther than d_max, the isosurface half-way is printed before it, cut to that place,
// and so on for both halves. Halving keeps partial layers in step with each other: their edges lie
// above each other instead of anywhere. What is still too thin, or cannot be carried, is cut off
// last, so that the thickness is bounded by construction.
#include "layers/adaptive_slicing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "layers/bead_height.h"
#include "layers/insertion.h"
#include "layers/isosurface.h"
#include "layers/layer_distance.h"
#include "layers/layer_parts.h"
#include "layers/remesh.h"
#include "layers/trim_to_range.h"

namespace s3 {
namespace {

std::string mm(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " mm";
}

Vec3 size_of(const Box& box) {
  return box.max - box.min;
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

// What was left of the range as a reserve for the difference between a raw isosurface and its
// remeshed form.
constexpr double kReserve = 0.02;
// The search for the next iso value ends when the thickest point is within this share of the range
// below the limit.
constexpr double kTargetWindow = 0.06;
constexpr int kMaxProbes = 7;
// Thickness from G is off by that much near jumps of ∇G; a rim is given up only beyond it.
constexpr double kEstimateSlack = 1.3;

// The cut zone reaches this share of the way from d_min to the thickness that the next layer could
// still cover.
constexpr double kCutZone = 0.5;
// What lies farther than d_max from the material although layers are inserted is left out as long
// as it is within this many d_max: the next layers close such a gap.
constexpr double kGapReach = 4;
constexpr int kLowerings = 2;
// A complete layer may be thinner than d_min on this share of its area, where it is cut.
constexpr double kThinShare = 0.02;
// The search for the lowest layer that is not too thin ends within this factor.
constexpr double kThinWindow = 1.15;
// Places that are too thick for any complete layer do not restrict it as long as they are this
// share of its area, and points within this many d_max of them do not either.
constexpr double kGivenUpShare = 0.02;
constexpr double kGivenUpRadius = 1.5;
// Half a step is not divided where it would be less than this many d_min along ∇G.
constexpr double kLeastStep = 0.5;
// A layer below a top has at least this many areas of a bead.
constexpr double kLeastTop = 4;

// An isosurface that may become the next layer.
struct Probe {
  double iso = 0;
  Isosurface surface;
  Measured distance;
  double thickest = 0;    // of the points that some iso value could bring into the range
  double too_thick = 0;   // share of the area that they are too thick on
  double suggestion = 0;  // the iso value at which the thickest would reach the goal
};

// A remeshed isosurface, cut where it would be too thin, before the last trimming.
struct Candidate {
  double iso = 0;
  bool partial = false;
  Isosurface surface;
  Measured distance;
};

class Slicer {
 public:
  Slicer(const TetMesh& rest, const ScalarField& field, const LayerParams& params, Context& ctx)
      : ctx_(ctx),
        extractor_(rest, field),
        part_(rest),
        tops_(rest, field),
        size_(size_of(bounding_box(rest.vertices))),
        d_min_(params.d_min()),
        d_max_(params.d_max()),
        bead_area_(params.nozzle_diameter * params.nozzle_diameter) {
    const double reserve = kReserve * (d_max_ - d_min_);
    low_ = d_min_ + reserve;
    high_ = d_max_ - reserve;
    range_ = {d_min_, d_max_, low_, high_, kGapReach * d_max_};
    slope_.resize(static_cast<std::size_t>(rest.tet_count()));
    for (Index t = 0; t < rest.tet_count(); ++t) slope_[t] = field.gradient.row(t).norm();
    target_.edge_length = std::max(0.7 * d_max_, 0.6 * mean_edge_length(rest));
    target_.boundary_tolerance = 0.02 * d_max_;
  }

  LayerStack adaptive();
  LayerStack even(double step);

 private:
  Probe probe(double iso);
  Probe next_surface(double top);
  Probe spread_to_top(Probe best, double top);
  double thin_area(const Probe& probe) const;
  double thin_quantile(const Probe& probe) const;
  Values keep_value(const Isosurface& surface, const Values& thickness) const;
  bool is_given_up(const Vec3& p) const;
  void give_up(const Probe& probe);
  Candidate make_candidate(Probe next);
  void lower_slightly(Candidate& candidate);
  void print_up_to(double from, Candidate layer);
  bool insert_between(double from, double to);
  bool print_tops(double from, double to);
  void trim(Candidate& candidate);
  void print(const Isosurface& whole, const Measured& distance, double iso, bool partial);
  void drop_slivers();
  void report_unsupported();
  [[noreturn]] void throw_empty() const;
  void finish();

  Context& ctx_;
  IsosurfaceExtractor extractor_;
  PartSurface part_;
  Tops tops_;
  PrintedMaterial material_;
  LayersAbove above_;  // of the running insertion
  LayerStack stack_;
  RemeshTarget target_;
  Vec3 size_;  // of the part, mm
  double d_min_, d_max_, low_, high_;
  ThicknessRange range_;
  double bead_area_;
  std::vector<double> slope_;            // #T ‖∇G‖
  std::vector<Vec3> given_up_;           // places beyond reach, of the running search
  double last_iso_ = 0, last_step_ = 0;  // of G
  std::vector<char> carries_;            // a component: points of later ones are nearest to it
};

// Slope ‖∇G‖ at each vertex: the mean over its triangles' tets.
Values vertex_slopes(const Isosurface& iso, const std::vector<double>& slope) {
  const Eigen::Index n = iso.surface.vertices.rows();
  Values sum = Values::Zero(n), count = Values::Zero(n);
  for (Eigen::Index f = 0; f < iso.surface.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      sum(iso.surface.triangles(f, i)) += slope[iso.source_tet[static_cast<std::size_t>(f)]];
      count(iso.surface.triangles(f, i)) += 1;
    }
  return sum.cwiseQuotient(count.cwiseMax(1));
}

// Area of the surface around each vertex: a third of its triangles.
Values vertex_areas(const Isosurface& iso) {
  const Points& points = iso.surface.vertices;
  Values area = Values::Zero(points.rows());
  for (Eigen::Index f = 0; f < iso.surface.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i)
      area(iso.surface.triangles(f, i)) +=
          triangle_normal_2a(points, iso.surface.triangles.row(f)).norm() / 6;
  return area;
}

// Extracts an isosurface and measures it against the material.
//
// A point is given up (it does not restrict the iso value) when no iso value could bring it into
// the range: it lies beyond d_max although the layer would be thinner than d_min at its foot. That
// is a rim that overhangs too far, or material that starts in the air.
Probe Slicer::probe(double iso) {
  ctx_.checkpoint();
  Probe result;
  result.iso = iso;
  result.surface = extractor_.extract(iso);
  const Points& points = result.surface.surface.vertices;
  result.distance = measure(material_, points, range_.far(), ctx_);
  const std::vector<Index>& below = result.distance.below;
  const Values slope = vertex_slopes(result.surface, slope_);
  const Values area = vertex_areas(result.surface);
  const double steepest = kEstimateSlack * high_ / low_;
  const double goal = high_ - 0.4 * kTargetWindow * (d_max_ - d_min_);
  result.suggestion = std::numeric_limits<double>::infinity();
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    if (!(slope(v) > 0)) continue;
    const double below_iso =
        below[v] == PrintedMaterial::kPlate ? 0.0 : stack_.layers[below[v]].iso_value;
    const double estimate = std::max((iso - below_iso) / slope(v), 0.0);
    const double risen = (iso - last_iso_) / slope(v);
    const double thickness = result.distance.thickness(v);
    if (thickness > high_ &&
        (thickness > steepest * estimate || thickness > low_ + steepest * risen ||
         is_given_up(points.row(v).transpose())))
      continue;
    result.thickest = std::max(result.thickest, thickness);
    if (thickness > high_) result.too_thick += area(v) / area.sum();
    const double growth = std::clamp(estimate > 0 ? thickness / estimate : 1.0, 1.0, steepest);
    result.suggestion = std::min(result.suggestion, iso + (goal - thickness) * slope(v) / growth);
  }
  return result;
}

bool Slicer::is_given_up(const Vec3& p) const {
  const double radius = kGivenUpRadius * d_max_;
  return std::any_of(given_up_.begin(), given_up_.end(),
                     [&](const Vec3& q) { return (p - q).squaredNorm() < radius * radius; });
}

// Notes the places that are too thick. Near ones stand for each other.
void Slicer::give_up(const Probe& probe) {
  const Points& points = probe.surface.surface.vertices;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    if (probe.distance.thickness(v) <= high_) continue;
    const Vec3 p = points.row(v).transpose();
    const double near = 0.5 * d_max_;
    if (std::none_of(given_up_.begin(), given_up_.end(),
                     [&](const Vec3& q) { return (p - q).squaredNorm() < near * near; }))
      given_up_.push_back(p);
  }
}

// The thickness that kThinShare of the area is below.
double Slicer::thin_quantile(const Probe& probe) const {
  const Values area = vertex_areas(probe.surface);
  std::vector<std::pair<double, double>> at;  // thickness, area
  for (Eigen::Index v = 0; v < area.size(); ++v)
    at.emplace_back(probe.distance.thickness(v), area(v));
  std::sort(at.begin(), at.end());
  double sum = 0;
  for (const auto& [thickness, around] : at) {
    sum += around;
    if (sum > kThinShare * area.sum()) return thickness;
  }
  return std::numeric_limits<double>::infinity();
}

// The next complete isosurface, by bracketing with the suggestions of the probes: the highest that
// is nowhere thicker than allowed or, where that would be too thin elsewhere, the lowest that is
// not. Few places that are too thick even for the latter are given up.
Probe Slicer::next_surface(double top) {
  Probe best;
  bool found = false, gave_up = false;
  const double infinity = std::numeric_limits<double>::infinity();
  double too_high = infinity;
  double guess = std::min(last_iso_ + last_step_, top);
  given_up_.clear();
  for (int round = 0; round < kMaxProbes; ++round) {
    Probe now = probe(guess);
    const double thin = thin_quantile(now), step = guess - last_iso_;
    const bool is_thin = thin<low_, is_thick = now.thickest> high_;
    if (guess >= top && (is_thin || !is_thick)) return now;
    if (is_thin) {
      guess += step * std::clamp(1.08 * low_ / std::max(thin, 0.1 * low_) - 1, 0.02, 2.0);
    } else if (!is_thick) {
      const bool full = now.thickest >= high_ - kTargetWindow * (d_max_ - d_min_);
      guess = std::min(now.suggestion, last_iso_ + 3 * step);
      best = std::move(now);
      found = true;
      if (full) break;
    } else if (thin > kThinWindow * low_) {
      too_high = guess;
      guess = std::max(now.suggestion, last_iso_ + step * 1.08 * low_ / thin);
    } else {
      if (gave_up || now.too_thick > kGivenUpShare) return now;
      give_up(now);
      gave_up = found = true;
      best = std::move(now);
      too_high = infinity;
      guess = last_iso_ + std::max(last_step_, 1.1 * step);
    }
    guess = std::min(guess, top);
    if (too_high == infinity) continue;
    const double from = found ? best.iso : last_iso_, span = too_high - from;
    if (found && span < 0.02 * (too_high - last_iso_)) break;
    guess = std::clamp(guess, from + 0.1 * span, too_high - 0.1 * span);
  }
  return found ? spread_to_top(std::move(best), top) : probe(guess);
}

double Slicer::thin_area(const Probe& probe) const {
  const TriMesh& surface = probe.surface.surface;
  double area = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corners = surface.triangles.row(f);
    const double mean =
        (probe.distance.thickness(corners(0)) + probe.distance.thickness(corners(1)) +
         probe.distance.thickness(corners(2))) /
        3;
    if (mean < low_) area += triangle_normal_2a(surface.vertices, corners).norm() / 2;
  }
  return area;
}

// Near the top the remaining height is divided evenly, so that the last layer ends at the top
// instead of below it.
Probe Slicer::spread_to_top(Probe best, double top) {
  constexpr int kLastLayers = 8;
  const double steps = std::ceil((top - last_iso_) / (best.iso - last_iso_) - 0.02);
  const double even = (top - last_iso_) / steps;
  if (steps < 2 || steps > kLastLayers || even > 0.98 * (best.iso - last_iso_)) return best;
  Probe spread = probe(last_iso_ + even);
  return spread.thickest <= high_ && thin_area(spread) <= thin_area(best) ? std::move(spread)
                                                                          : std::move(best);
}

// Where to keep an isosurface: not negative exactly on the kept part. What is too thin must go;
// with it goes the zone around it that is hardly thicker, so that the next layer, which is carried
// by the edge of this one, is not too thin there in turn.
Values Slicer::keep_value(const Isosurface& surface, const Values& thickness) const {
  const SurfaceEdges edges(surface.surface.triangles, static_cast<Index>(thickness.size()));
  const double margin = low_ + kCutZone * std::max(0.5 * high_ - low_, 0.0);
  std::vector<std::vector<Index>> neighbors(static_cast<std::size_t>(thickness.size()));
  for (Eigen::Index e = 0; e < edges.ends.rows(); ++e) {
    neighbors[edges.ends(e, 0)].push_back(edges.ends(e, 1));
    neighbors[edges.ends(e, 1)].push_back(edges.ends(e, 0));
  }
  std::vector<char> removed(neighbors.size(), 0);
  std::vector<Index> front;
  for (Eigen::Index v = 0; v < thickness.size(); ++v)
    if (thickness(v) < low_) front.push_back(static_cast<Index>(v));
  for (const Index v : front) removed[v] = 1;
  while (!front.empty()) {
    const Index v = front.back();
    front.pop_back();
    for (const Index w : neighbors[v])
      if (!removed[w] && thickness(w) < margin) {
        removed[w] = 1;
        front.push_back(w);
      }
  }
  Values keep(thickness.size());
  for (Eigen::Index v = 0; v < keep.size(); ++v)
    keep(v) = removed[v] ? std::min(thickness(v) - margin, -1e-9 * margin)
                         : std::max(thickness(v) - margin, 1e-9 * margin);
  return keep;
}

// Adds the components of a surface to the stack and to the material.
void Slicer::print(const Isosurface& whole, const Measured& distance, double iso, bool partial) {
  const Values height =
      bead_heights(material_, part_.tree(), whole.surface, whole.normal, d_min_, d_max_, ctx_);
  std::vector<Layer> printed;
  for (SurfacePart& part : split_components(whole)) {
    Layer layer;
    layer.surface = std::move(part.surface.surface);
    layer.normal = std::move(part.surface.normal);
    layer.source_tet = std::move(part.surface.source_tet);
    layer.iso_value = iso;
    layer.layer = stack_.isosurfaces;
    layer.partial = partial;
    layer.thickness.resize(static_cast<Eigen::Index>(part.vertices.size()));
    layer.bead_height = height(part.vertices);
    for (std::size_t v = 0; v < part.vertices.size(); ++v) {
      const double thickness = distance.thickness(part.vertices[v]);
      layer.thickness(static_cast<Eigen::Index>(v)) = thickness;
      const Index below = distance.below[part.vertices[v]];
      if (below != PrintedMaterial::kPlate && thickness <= d_max_) layer.rests_on.push_back(below);
    }
    std::sort(layer.rests_on.begin(), layer.rests_on.end());
    layer.rests_on.erase(std::unique(layer.rests_on.begin(), layer.rests_on.end()),
                         layer.rests_on.end());
    // A scrap that a later layer can cover is left to it.
    if (partial && surface_area(layer.surface) < bead_area_ &&
        layer.thickness.maxCoeff() <= 0.5 * high_)
      continue;
    printed.push_back(std::move(layer));
  }
  if (printed.empty()) return;
  for (Layer& layer : printed) {
    material_.add(layer.surface, static_cast<Index>(stack_.layers.size()));
    stack_.layers.push_back(std::move(layer));
    carries_.push_back(0);
  }
  ++stack_.isosurfaces;
}

// Takes out components too small for a bead that carry nothing: tips, and scraps between others.
void Slicer::drop_slivers() {
  std::vector<char> dropped(stack_.layers.size(), 0);
  for (std::size_t k = stack_.layers.size(); k-- > 0;) {
    const Layer& layer = stack_.layers[k];
    const double area = surface_area(layer.surface);
    if (!carries_[k] && area < bead_area_) {
      dropped[k] = 1;
      stack_.dropped_area += area;
      stack_.dropped_places.push_back(layer.surface.vertices.colwise().mean().transpose());
      continue;
    }
    for (const Index below : layer.rests_on) carries_[below] = 1;
  }
  std::reverse(stack_.dropped_places.begin(), stack_.dropped_places.end());
  std::vector<Index> position(stack_.layers.size(), -1);
  std::vector<Layer> kept;
  Index last = -1;
  stack_.isosurfaces = 0;
  for (std::size_t k = 0; k < stack_.layers.size(); ++k) {
    if (dropped[k]) continue;
    Layer& layer = stack_.layers[k];
    position[k] = static_cast<Index>(kept.size());
    for (Index& below : layer.rests_on) below = position[below];
    if (layer.layer != last) {
      last = layer.layer;
      ++stack_.isosurfaces;
    }
    layer.layer = stack_.isosurfaces - 1;
    kept.push_back(std::move(layer));
  }
  stack_.layers = std::move(kept);
}

// Lists the pieces of layers that lie farther than d_max from everything printed before them.
void Slicer::report_unsupported() {
  for (const Layer& layer : stack_.layers) {
    std::vector<char> in_air(static_cast<std::size_t>(layer.surface.triangles.rows()), 0);
    bool any = false;
    for (Eigen::Index f = 0; f < layer.surface.triangles.rows(); ++f) {
      const auto corners = layer.surface.triangles.row(f);
      const double mean = (layer.thickness(corners(0)) + layer.thickness(corners(1)) +
                           layer.thickness(corners(2))) /
                          3;
      any |= in_air[static_cast<std::size_t>(f)] = mean > d_max_;
    }
    if (!any) continue;
    Isosurface whole;
    whole.surface = layer.surface;
    whole.normal = layer.normal;
    whole.source_tet = layer.source_tet;
    for (const SurfacePart& part : split_components(extract_flagged(whole, in_air).surface)) {
      stack_.unsupported_area += surface_area(part.surface.surface);
      stack_.unsupported_places.push_back(
          part.surface.surface.vertices.colwise().mean().transpose());
    }
  }
  const auto square_mm = [](double area) {
    return std::to_string(std::round(100 * area) / 100)
               .substr(0, std::to_string(std::round(100 * area) / 100).find('.') + 3) +
           " mm²";
  };
  if (!stack_.unsupported_places.empty())
    ctx_.warn("layers.unsupported",
              square_mm(stack_.unsupported_area) + " of layer area in " +
                  std::to_string(stack_.unsupported_places.size()) + " places lie more than " +
                  mm(d_max_) + " from anything printed before; they start in the air.",
              stack_.unsupported_places);
  if (!stack_.dropped_places.empty())
    ctx_.warn("layers.dropped",
              std::to_string(stack_.dropped_places.size()) + " pieces, together " +
                  square_mm(stack_.dropped_area) +
                  ", are not printed: too small for a bead, or a rim just out of reach.",
              stack_.dropped_places);
}

void Slicer::throw_empty() const {
  throw Error(ErrorKind::input, Stage::layers, "layers.empty",
              "The part has no layer: it measures " + mm(size_.x()) + " × " + mm(size_.y()) +
                  " × " + mm(size_.z()) + ", the thinnest layer " + mm(d_min_),
              "If the file is not in millimetres, give its unit by input.scale (1000 for metres, "
              "25.4 for inches); otherwise use a finer nozzle");
}

void Slicer::finish() {
  drop_slivers();
  if (stack_.layers.empty()) throw_empty();
  report_unsupported();
  ctx_.progress(Stage::layers, 1);
}

Candidate Slicer::make_candidate(Probe next) {
  refine_extremes(material_, range_, low_, std::numeric_limits<double>::infinity(), next.surface,
                  next.distance, ctx_);
  const Values keep = keep_value(next.surface, next.distance.thickness);
  Candidate candidate;
  candidate.iso = next.iso;
  candidate.partial = keep.size() > 0 && keep.minCoeff() < 0;
  candidate.surface = remesh(
      candidate.partial ? cut_where_negative(next.surface, keep) : next.surface, target_, ctx_);
  candidate.distance = measure(material_, candidate.surface.surface.vertices, range_.far(), ctx_);
  refine_extremes(material_, range_, d_min_, d_max_, candidate.surface, candidate.distance, ctx_);
  return candidate;
}

// Remeshing moves points by a little: where that made a complete layer too thick, one that is lower
// by as much takes its place, as long as it is complete too.
void Slicer::lower_slightly(Candidate& candidate) {
  for (int i = 0; i < kLowerings && !candidate.partial; ++i) {
    const double thickest = slight_excess(range_, candidate.surface, candidate.distance, given_up_);
    if (thickest == 0) return;
    const double step = (candidate.iso - last_iso_) * (1 - 1.5 * (thickest / high_ - 1));
    Candidate lower = make_candidate(probe(last_iso_ + step));
    if (lower.partial) return;
    candidate = std::move(lower);
  }
}

void Slicer::trim(Candidate& candidate) {
  const Trimmed trimmed =
      trim_to_range(material_, range_, candidate.surface, candidate.distance, ctx_);
  stack_.dropped_area += trimmed.left_out_area;
  stack_.dropped_places.insert(stack_.dropped_places.end(), trimmed.left_out_places.begin(),
                               trimmed.left_out_places.end());
  for (const Index below : trimmed.carriers) carries_[below] = 1;
}

// Prints what a layer needs below it to be nowhere farther than d_max from the material, then the
// layer.
void Slicer::print_up_to(double from, Candidate layer) {
  above_.push(layer.surface.surface, layer.distance.thickness);
  const bool inserted = insert_between(from, layer.iso);
  above_.pop();
  if (layer.surface.surface.triangles.rows() == 0) return;
  if (inserted) {
    layer.distance = measure(material_, layer.surface.surface.vertices, range_.far(), ctx_);
    refine_extremes(material_, range_, d_min_, d_max_, layer.surface, layer.distance, ctx_);
  }
  trim(layer);
  print(layer.surface, layer.distance, layer.iso, layer.partial);
}

// Halves the step to the lowest layer above where that is too thick: prints the isosurface half-way
// there, with what that needs in turn, and what is needed between the two.
// @return whether the material may be another
bool Slicer::insert_between(double from, double to) {
  Candidate half;
  half.iso = 0.5 * (from + to);
  half.partial = true;
  const Probe middle = probe(half.iso);
  Room room = measure_room(middle.surface, middle.distance, above_, part_, range_, ctx_);
  const Values slope = vertex_slopes(middle.surface, slope_);
  for (Eigen::Index v = 0; v < slope.size(); ++v)
    if (half.iso - from < kLeastStep * low_ * slope(v)) room.span(v) = 0;
  if (area_beyond(middle.surface, room.span, range_) < bead_area_) return print_tops(from, to);
  half.surface = remesh(insertion(middle.surface, room, range_, bead_area_), target_, ctx_);
  half.distance = measure(material_, half.surface.surface.vertices, range_.far(), ctx_);
  refine_extremes(material_, range_, d_min_, d_max_, half.surface, half.distance, ctx_);
  print_up_to(from, std::move(half));
  insert_between(middle.iso, to);
  return true;
}

// Prints one more layer below the tops of the part that the next layer does not reach.
// @return whether the material may be another
bool Slicer::print_tops(double from, double to) {
  const Tops::Choice choice = tops_.between(from, to, low_);
  if (choice.volume < kLeastTop * bead_area_ * low_) return false;
  Candidate top;
  const Probe next = probe(choice.iso);
  top.surface =
      below_tops(next.surface, next.distance, above_, part_, range_, kLeastTop * bead_area_, ctx_);
  if (top.surface.surface.triangles.rows() == 0) return false;
  top.iso = choice.iso;
  top.partial = true;
  top.surface = remesh(top.surface, target_, ctx_);
  top.distance = measure(material_, top.surface.surface.vertices, range_.far(), ctx_);
  refine_extremes(material_, range_, d_min_, d_max_, top.surface, top.distance, ctx_);
  trim(top);
  print(top.surface, top.distance, top.iso, top.partial);
  return true;
}

LayerStack Slicer::adaptive() {
  const double bottom = std::max(extractor_.min_value(), 0.0);
  std::vector<double> slopes = slope_;
  std::nth_element(slopes.begin(), slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2),
                   slopes.end());
  last_iso_ = bottom;
  last_step_ = 0.8 * high_ * slopes[slopes.size() / 2];
  const double top = extractor_.max_value() - 1e-3 * last_step_;
  while (last_iso_ < top) {
    ctx_.progress(Stage::layers, std::min((last_iso_ - bottom) / (top - bottom), 1.0));
    Candidate next = make_candidate(next_surface(top));
    lower_slightly(next);
    const double iso = next.iso;
    print_up_to(last_iso_, std::move(next));
    last_step_ = iso - last_iso_;
    last_iso_ = iso;
  }
  finish();
  return std::move(stack_);
}

LayerStack Slicer::even(double step) {
  const double bottom = extractor_.min_value(), height = extractor_.max_value() - bottom;
  const double count = std::floor(height / step * (1 + 1e-9));
  for (double i = 1; i <= count; ++i) {
    ctx_.progress(Stage::layers, i / count);
    const double iso = bottom + i * step;
    const Isosurface whole = remesh(extractor_.extract(iso), target_, ctx_);
    print(whole, measure(material_, whole.surface.vertices, range_.far(), ctx_), iso, false);
  }
  finish();
  return std::move(stack_);
}

}  // namespace

LayerStack make_layers(const TetMesh& rest, const ScalarField& field, const LayerParams& params,
                       Context& ctx) {
  check_range(params);
  return Slicer(rest, field, params, ctx).adaptive();
}

LayerStack make_planar_layers(const TetMesh& rest, double layer_height, const LayerParams& params,
                              Context& ctx) {
  check_range(params);
  const ScalarField height = make_scalar_field(rest, rest.vertices.col(2));
  return Slicer(rest, height, params, ctx).even(layer_height);
}

}  // namespace s3
