// Adaptive slicing (Sec. 4.2). The paper spaces complete isosurfaces at d_min, halves gaps beyond
// d_max and removes what is then thinner than d_min. Here the same three steps are one sweep over
// the printed material, which bounds the thickness by construction: the next isosurface is the
// highest whose distance to the material stays below d_max everywhere, and what is nearer than
// d_min is left out of it, to be covered by a later one.
#include "layers/adaptive_slicing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "layers/isosurface.h"
#include "layers/layer_distance.h"
#include "layers/layer_parts.h"
#include "layers/remesh.h"

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

// What was left of the range as a reserve for the difference between a raw isosurface and its
// remeshed form.
constexpr double kReserve = 0.02;
// The search for the next iso value ends when the thickest point is within this share of the range
// below the limit.
constexpr double kTargetWindow = 0.06;
constexpr int kMaxProbes = 7;
// The distances are searched for up to this multiple of d_max: what is farther is in the air.
constexpr double kSearchFactor = 4;
// Thickness from G is off by that much near jumps of ∇G; a rim is given up only beyond it.
constexpr double kEstimateSlack = 1.3;

// An isosurface that may become the next layer.
struct Probe {
  double iso = 0;
  Isosurface surface;
  Values thickness;       // #V mm, to the material so far
  double thickest = 0;    // of the points that some iso value could bring into the range
  double suggestion = 0;  // the iso value at which the thickest would reach the goal
};

class Slicer {
 public:
  Slicer(const TetMesh& rest, const ScalarField& field, const LayerParams& params, Context& ctx)
      : rest_(rest),
        field_(field),
        ctx_(ctx),
        extractor_(rest, field),
        d_min_(params.d_min()),
        d_max_(params.d_max()),
        bead_area_(params.nozzle_diameter * params.nozzle_diameter) {
    const double reserve = kReserve * (d_max_ - d_min_);
    low_ = d_min_ + reserve;
    high_ = d_max_ - reserve;
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
  double lowest_step(const Probe& probe) const;
  Values keep_value(const Probe& probe) const;
  void print(const Isosurface& kept, double iso, bool partial);
  Values measure(const Points& points) const;

  const TetMesh& rest_;
  const ScalarField& field_;
  Context& ctx_;
  IsosurfaceExtractor extractor_;
  PrintedMaterial material_;
  LayerStack stack_;
  RemeshTarget target_;
  double d_min_, d_max_, low_, high_;
  double bead_area_;
  std::vector<double> slope_;            // #T ‖∇G‖
  double last_iso_ = 0, last_step_ = 0;  // of G
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
  result.thickness.resize(points.rows());
  std::vector<Index> below(static_cast<std::size_t>(points.rows()));
  parallel_for(ctx_.pool, below.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const auto row = static_cast<Eigen::Index>(v);
      const auto nearest = material_.nearest(points.row(row).transpose(), kSearchFactor * d_max_);
      result.thickness(row) = nearest.distance;
      below[v] = nearest.id;
    }
  });
  const Values slope = vertex_slopes(result.surface, slope_);
  const double steepest = kEstimateSlack * high_ / low_;
  const double goal = high_ - 0.4 * kTargetWindow * (d_max_ - d_min_);
  result.suggestion = std::numeric_limits<double>::infinity();
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    if (!(slope(v) > 0)) continue;
    const double below_iso =
        below[v] == PrintedMaterial::kPlate ? 0.0 : stack_.layers[below[v]].iso_value;
    const double estimate = std::max((iso - below_iso) / slope(v), 0.0);
    const double risen = (iso - last_iso_) / slope(v);
    const double thickness = result.thickness(v);
    if (thickness > high_ &&
        (thickness > steepest * estimate || thickness > low_ + steepest * risen))
      continue;
    result.thickest = std::max(result.thickest, thickness);
    const double growth = std::clamp(estimate > 0 ? thickness / estimate : 1.0, 1.0, steepest);
    result.suggestion = std::min(result.suggestion, iso + (goal - thickness) * slope(v) / growth);
  }
  return result;
}

// The smallest sensible step: half of d_min where the surface is slackest (but for outliers).
double Slicer::lowest_step(const Probe& probe) const {
  std::vector<double> slopes;
  slopes.reserve(probe.surface.source_tet.size());
  for (const Index t : probe.surface.source_tet) slopes.push_back(slope_[t]);
  if (slopes.empty()) return 0.5 * low_;
  const auto nth = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 20);
  std::nth_element(slopes.begin(), nth, slopes.end());
  return 0.5 * low_ * std::max(*nth, 1e-3);
}

// The highest isosurface above the last that is nowhere thicker than allowed, by bracketing with
// the suggestions of the probes.
Probe Slicer::next_surface(double top) {
  Probe best;
  bool found = false;
  double infeasible = std::numeric_limits<double>::infinity();
  double guess = std::min(last_iso_ + last_step_, top);
  double floor = last_iso_;
  for (int round = 0; round < kMaxProbes; ++round) {
    Probe now = probe(guess);
    floor = std::min(last_iso_ + lowest_step(now), top);
    double next = std::min(now.suggestion, top);
    if (now.thickest <= high_) {
      const bool full = now.thickest >= high_ - kTargetWindow * (d_max_ - d_min_) || guess >= top;
      best = std::move(now);
      found = true;
      if (full) break;
      next = std::min(next, last_iso_ + 3 * (guess - last_iso_));
    } else {
      infeasible = guess;
      if (guess <= floor) return now;
    }
    const double feasible = found ? best.iso : floor;
    if (std::isfinite(infeasible)) {
      const double span = infeasible - feasible;
      if (found && span < 0.02 * (infeasible - last_iso_)) break;
      next = std::clamp(next, feasible + (found ? 0.1 * span : 0.0), infeasible - 0.1 * span);
    }
    guess = std::max(next, floor);
  }
  return found ? spread_to_top(std::move(best), top) : probe(floor);
}

double Slicer::thin_area(const Probe& probe) const {
  const TriMesh& surface = probe.surface.surface;
  double area = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corners = surface.triangles.row(f);
    const double mean =
        (probe.thickness(corners(0)) + probe.thickness(corners(1)) + probe.thickness(corners(2))) /
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

// Where to keep an isosurface: not negative exactly on the kept part. The cut follows the smoothed
// thickness, so that it does not fray; it may take away what a later layer can cover, and must take
// away what is too thin.
Values Slicer::keep_value(const Probe& probe) const {
  const TriMesh& surface = probe.surface.surface;
  constexpr int kSmoothing = 3;
  Values smooth = probe.thickness;
  for (int round = 0; round < kSmoothing; ++round) {
    Values sum = smooth, count = Values::Ones(smooth.size());
    for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
      for (int i = 0; i < 3; ++i) {
        sum(surface.triangles(f, i)) +=
            smooth(surface.triangles(f, (i + 1) % 3)) + smooth(surface.triangles(f, (i + 2) % 3));
        count(surface.triangles(f, i)) += 2;
      }
    smooth = sum.cwiseQuotient(count);
  }
  for (Eigen::Index v = 0; v < smooth.size(); ++v) {
    const double thickness = probe.thickness(v);
    if (thickness > 0.5 * high_) smooth(v) = std::max(smooth(v), low_ + 0.1 * (thickness - low_));
    smooth(v) = std::min(smooth(v), thickness) - low_;
  }
  return smooth;
}

Values Slicer::measure(const Points& points) const {
  Values thickness(points.rows());
  parallel_for(
      ctx_.pool, static_cast<std::size_t>(points.rows()), 256,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          const auto row = static_cast<Eigen::Index>(v);
          thickness(row) =
              material_.nearest(points.row(row).transpose(), kSearchFactor * d_max_).distance;
        }
      });
  return thickness;
}

// Remeshes a surface and adds its components to the stack and to the material.
void Slicer::print(const Isosurface& kept, double iso, bool partial) {
  Isosurface even = remesh(kept, target_);
  std::vector<Layer> printed;
  for (Isosurface& part : split_components(even)) {
    Layer layer;
    layer.thickness = measure(part.surface.vertices);
    layer.surface = std::move(part.surface);
    layer.normal = std::move(part.normal);
    layer.source_tet = std::move(part.source_tet);
    layer.iso_value = iso;
    layer.layer = stack_.isosurfaces;
    layer.partial = partial;
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
  }
  ++stack_.isosurfaces;
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
    const Probe next = next_surface(top);
    const Values keep = keep_value(next);
    const bool partial = keep.size() > 0 && keep.minCoeff() < 0;
    if (keep.size() > 0)
      print(partial ? cut_where_negative(next.surface, keep) : next.surface, next.iso, partial);
    last_step_ = next.iso - last_iso_;
    last_iso_ = next.iso;
  }
  ctx_.progress(Stage::layers, 1);
  return std::move(stack_);
}

LayerStack Slicer::even(double step) {
  const double bottom = extractor_.min_value(), height = extractor_.max_value() - bottom;
  const double count = std::floor(height / step * (1 + 1e-9));
  for (double i = 1; i <= count; ++i) {
    ctx_.progress(Stage::layers, i / count);
    print(extractor_.extract(bottom + i * step), bottom + i * step, false);
  }
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
