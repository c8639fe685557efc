#include "scalar_field/refine.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "base/units.h"
#include "math/sparse_solver.h"
#include "objectives/feasible_region.h"
#include "objectives/gauss_sphere.h"
#include "quaternion_field/concavity_weights.h"
#include "scalar_field/islands.h"

namespace s3 {

namespace {

constexpr int kIterations = 60;
constexpr int kStrengthIterations = 400;  // SR turns layers far: topopt gains 5 points of SR by 400

// Weights, for each mm³ of the solid; only their ratios matter.
constexpr double kHard = 25;   // on tets with a surface or stress objective: the unit of the others
constexpr double kRange = 10;  // the same constraints on all other tets, which have only to follow
// The same with SR, which pulls on whole struts while SF holds their undersides alone.
constexpr double kStrengthHard = 80, kStrengthRange = 12;
constexpr double kSupport = 600;     // on edges that support islands
constexpr double kConcavity = 60;    // on faces; 30 leaves some valleys
constexpr double kSmoothness = 0.2;  // squared jump of ∇G; much more keeps overhangs from turning
constexpr double kProximity = 0.01;  // to the start: decides only what nothing else does
constexpr double kQuality = 120;     // soft, SQ, where it is the first of the objectives
constexpr double kStrength = 65;     // soft, SR, likewise

// A soft objective pulls no harder than from this far away, as a share of the usual ‖∇G‖: places
// that cannot comply hold back those that can as little as possible. Worth 2 points of SQ area on
// the ankle.
constexpr double kQualityReach = 0.12;
constexpr double kStrengthReach = 0.3;
// SR weighs as much more as a critical tet is pulled more than the mean of S, within these bounds:
// the part breaks where it is pulled most, and the first places to give up must not be those. On
// the bunny, whose ears carry 20 times the mean, the largest strain falls by 40 % through it.
constexpr double kLeastTension = 0.75, kMostTension = 8;
// Then they give up: from the first share of the iterations to the second, the distance at which
// the pull begins to fade shrinks (graduated non-convexity, Blake and Zisserman 1987, with the
// weight of Geman and McClure). Otherwise critical tets that stand on the plate tear the layers
// around them and win nothing: on the bundled bridge 200 valleys over 20° become 24.
constexpr double kFadeBegin = 0.3, kFadeEnd = 0.8;
constexpr double kNearFade = 0.2;  // of the usual ‖∇G‖, at the end
constexpr int kFadeHalvings = 4;

// Constraints aim this far inside their border: solutions come to lie around it.
constexpr double kAlphaMargin = radians(2), kStrengthAlphaMargin = radians(3.75);
// SR is soft and stops where it would be met: without a margin half of the critical tets of the
// bridge end just outside.
constexpr double kBetaMargin = radians(6.5);
constexpr double kTiltMargin = radians(1);
// Valleys over 20° make poor surfaces; the clamp acts before.
constexpr double kPoorConcaveAngle = radians(20);
constexpr double kClampedAngle = radians(16);

// Layers rise from what supports an island at least by this share of the usual ‖∇G‖: critical
// struts allow no more than sin β along them.
constexpr double kSupportRise = 0.02;
// An island's way to the plate is no steeper downwards than layers at the machine's tilt could
// follow, by this much.
constexpr double kWayMargin = 0.1;

// Duals forget: constraints in conflict would grow without bound.
constexpr double kLeak = 0.95;
constexpr double kJumpLeak = 0.98;
constexpr double kSupportLeak = 0.98;
// Of each solve; the next iteration corrects what it leaves.
constexpr double kTolerance = 0.1;
constexpr int kCheckEvery = 5;  // iterations

// Shares that weigh as much as the whole surface in choosing the best iterate.
constexpr double kConcaveCost = 50;              // of concave pairs and of inverted tets
constexpr double kIslandCost = 0.002;            // each
constexpr double kConformalAngle = radians(10);  // a surface this close to its layer looks smooth

constexpr std::size_t kGrain = 4096;

// What is asked of one tet beyond the machine's cone and the range of ‖∇G‖.
struct TetConstraint {
  FeasibleRegion hard, soft;
  double soft_weight = 0;
};

// An edge of the solid along which G must rise: its upper end shall not start in the air.
struct Support {
  Index below;
  double rise, weight;  // mm; times (mm of G)²
  double dual = 0;
};

// The concave jump of ∇G across a face at which the print directions differ by the angle whose
// tangent is given: the normal parts are b ± k and the tangential part is t, so atan((b + k)/t) −
// atan((b − k)/t) is the angle.
double jump_limit(double t2, double b, double tan_angle) {
  const double t = std::sqrt(t2);
  return 2 * (std::sqrt(t2 + tan_angle * tan_angle * (t2 + b * b)) - t) / tan_angle;
}

// Where pulls begin to fade, of the usual ‖∇G‖, after this share of the iterations.
double fade_distance(double progress) {
  if (progress < kFadeBegin) return std::numeric_limits<double>::infinity();
  const double left =
      kFadeHalvings * std::max(0.0, (kFadeEnd - progress) / (kFadeEnd - kFadeBegin));
  // Straight between the powers of two: no library function, so that every machine agrees.
  const double whole = std::floor(left);
  return std::ldexp(kNearFade * (1 + left - whole), static_cast<int>(whole));
}

double median_length(const Points& vectors) {
  std::vector<double> length(static_cast<std::size_t>(vectors.rows()));
  for (std::size_t t = 0; t < length.size(); ++t)
    length[t] = vectors.row(static_cast<Eigen::Index>(t)).norm();
  const auto middle = length.begin() + static_cast<std::ptrdiff_t>(length.size() / 2);
  std::nth_element(length.begin(), middle, length.end());
  return *middle;
}

class Refinement {
 public:
  Refinement(const TetMesh& rest, const FieldOperators& op, const Anchors& anchors,
             const ObjectiveField& objectives, const ObjectiveParams& objective_params,
             const Values& start, const RefineParams& params, Context& ctx);

  Values run();

 private:
  void make_constraints(const ObjectiveParams& params);
  double mean_tension() const;
  double tension_weight(Index t) const;
  void prepare_solver();
  void clamp_jumps();
  void project_tets();
  Vec3 tet_force(Index t);
  Vec3 soft_pull(const TetConstraint& constraint, const Vec3& g) const;
  void solve();
  void pull_supports();
  void turn_tets_of_minima(const std::vector<std::vector<Index>>& minima);
  void support_vertex_above(Index from, Index to);
  void support_minima(const std::vector<std::vector<Index>>& minima);
  bool support(Index vertex, Index below);
  double score(Index islands, const Values& omega) const;

  const TetMesh& rest_;
  const FieldOperators& op_;
  const Anchors& anchors_;
  const ObjectiveField& objectives_;
  const ObjectiveParams& params_;
  const double cos_tilt_;
  const double least_slope_;  // of ways from the plate
  Context& ctx_;

  Values value_;
  Points start_gradient_, gradient_, dual_, force_;
  double usual_ = 0, shortest_ = 0, longest_ = 0;  // ‖∇G‖: median and bounds
  double mean_tension_ = 0;                        // in S
  int iterations_ = kIterations;
  double fade_ = std::numeric_limits<double>::infinity();  // of soft objectives, now
  FeasibleRegion machine_;                                 // the cone alone
  std::vector<Index> constraint_of_;                       // #T, −1 for none
  std::vector<TetConstraint> constraints_;
  Values hard_weight_;                 // #T, times volume
  Values jump_dual_, jump_force_;      // #N
  std::map<Index, Support> supports_;  // of each vertex that has one
  std::unique_ptr<SpdSolver> solver_;
  Values vertex_force_;
  Block right_, change_;
};

Refinement::Refinement(const TetMesh& rest, const FieldOperators& op, const Anchors& anchors,
                       const ObjectiveField& objectives, const ObjectiveParams& objective_params,
                       const Values& start, const RefineParams& params, Context& ctx)
    : rest_(rest),
      op_(op),
      anchors_(anchors),
      objectives_(objectives),
      params_(objective_params),
      cos_tilt_(std::cos(std::max(0.5 * params.max_tilt, params.max_tilt - kTiltMargin))),
      least_slope_(kWayMargin - std::sqrt(1 - cos_tilt_ * cos_tilt_)),
      ctx_(ctx),
      value_(start),
      dual_(Points::Zero(rest.tet_count(), 3)),
      force_(rest.tet_count(), 3),
      jump_dual_(Values::Zero(rest.face_pairs.rows())),
      jump_force_(rest.face_pairs.rows()),
      right_(anchors.free_count, 1),
      change_(anchors.free_count, 1) {
  op_.gradients(value_, start_gradient_, ctx_);
  usual_ = median_length(start_gradient_);
  shortest_ = usual_ / std::sqrt(params.thickness_ratio);
  longest_ = usual_ * std::sqrt(params.thickness_ratio);
  if (!objectives.critical.empty()) iterations_ = kStrengthIterations;
  machine_.cos_tilt = cos_tilt_;
  mean_tension_ = mean_tension();
  make_constraints(objective_params);
  prepare_solver();
}

// Of the critical tets, by volume; 0 without any.
double Refinement::mean_tension() const {
  double pull = 0, volume = 0;
  for (Index t = 0; t < static_cast<Index>(objectives_.critical.size()); ++t) {
    if (!objectives_.critical[t]) continue;
    pull += objectives_.tension(t) * op_.volume(t);
    volume += op_.volume(t);
  }
  return volume > 0 ? pull / volume : 0;
}

double Refinement::tension_weight(Index t) const {
  return std::clamp(objectives_.tension(t) / mean_tension_, kLeastTension, kMostTension);
}

void Refinement::make_constraints(const ObjectiveParams& params) {
  const bool strength = !objectives_.critical.empty();
  const RegionBounds hard = region_bounds(params, strength ? kStrengthAlphaMargin : kAlphaMargin);
  RegionBounds soft = region_bounds(params);
  soft.sin_beta = std::sin(std::max(0.0, radians(params.beta_deg) - kBetaMargin));
  const double constrained = strength ? kStrengthHard : kHard;
  const double others = strength ? kStrengthRange : kRange;
  const double first = std::max({params.support_free, params.surface_quality, params.strength});
  constraint_of_.assign(static_cast<std::size_t>(rest_.tet_count()), -1);
  hard_weight_.resize(rest_.tet_count());
  for (Index t = 0; t < rest_.tet_count(); ++t) {
    hard_weight_(t) = others * op_.volume(t);
    TetConstraint c{.hard = machine_, .soft = feasible_region(objectives_, soft, t)};
    if (!c.soft.constrained()) continue;
    c.soft.on_plate = false;  // the anchors hold the plate
    c.soft.cos_tilt = cos_tilt_;
    if (params.support_free > 0) {
      c.hard = feasible_region(objectives_, hard, t);
      c.hard.on_plate = c.hard.critical = false;
      c.hard.cos_tilt = cos_tilt_;
      for (FeasibleRegion::Face& face : c.hard.faces) face.quality = false;
    }
    const bool quality = std::any_of(c.soft.faces.begin(), c.soft.faces.begin() + c.soft.face_count,
                                     [](const auto& face) { return face.quality; });
    if (quality) c.soft_weight = kQuality * params.surface_quality / first;
    if (c.soft.critical)
      c.soft_weight =
          std::max(c.soft_weight, kStrength * params.strength / first * tension_weight(t));
    hard_weight_(t) = constrained * op_.volume(t);
    constraint_of_[t] = static_cast<Index>(constraints_.size());
    constraints_.push_back(c);
  }
}

void Refinement::prepare_solver() {
  Values tet_weight(rest_.tet_count()), pair_weight(rest_.face_pairs.rows());
  for (Index t = 0; t < rest_.tet_count(); ++t) {
    const double soft = constraint_of_[t] < 0 ? 0 : constraints_[constraint_of_[t]].soft_weight;
    tet_weight(t) = hard_weight_(t) + (kProximity + soft) * op_.volume(t);
  }
  for (Index p = 0; p < rest_.face_pairs.rows(); ++p)
    pair_weight(p) = (kSmoothness + kConcavity) * op_.face_weight(p);
  SparseMatrix matrix = op_.energy(tet_weight, pair_weight, anchors_.free_index, ctx_);
  for (const auto& [vertex, support] : supports_) {
    const Index high = anchors_.free_index[vertex], low = anchors_.free_index[support.below];
    if (high >= 0) matrix.coeffRef(high, high) += support.weight;
    if (low >= 0) matrix.coeffRef(low, low) += support.weight;
    if (high < 0 || low < 0) continue;
    matrix.coeffRef(high, low) -= support.weight;
    matrix.coeffRef(low, high) -= support.weight;
  }
  solver_ = make_solver({.tolerance = kTolerance});
  solver_->factor(matrix, ctx_);
}

Values Refinement::run() {
  Values best = value_;
  double best_score = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration <= iterations_; ++iteration) {
    op_.gradients(value_, gradient_, ctx_);
    if (iteration % kCheckEvery == 0 && iteration > 0) {
      const auto minima = find_minima(rest_, op_, objectives_, value_);
      if (objectives_.critical.empty())
        turn_tets_of_minima(minima);
      else
        support_minima(minima);
      const Values omega = concave_angles(rest_, gradient_.rowwise().normalized());
      const double now = score(static_cast<Index>(minima.size()), omega);
      if (2 * iteration >= iterations_ && now < best_score) {
        best_score = now;
        best = value_;
      }
    }
    if (iteration == iterations_) break;
    fade_ = usual_ * fade_distance(static_cast<double>(iteration) / iterations_);
    clamp_jumps();
    project_tets();
    solve();
    ctx_.progress(Stage::scalar_field, (iteration + 1.0) / iterations_);
  }
  return best;
}

void Refinement::clamp_jumps() {
  const double tan_angle = std::tan(kClampedAngle);
  parallel_for(
      ctx_.pool, static_cast<std::size_t>(rest_.face_pairs.rows()), kGrain,
      [&](std::size_t begin, std::size_t end) {
        for (auto p = static_cast<Index>(begin); p < static_cast<Index>(end); ++p) {
          const Vec3 n = op_.face_normal(p);
          const Vec3 first = gradient_.row(rest_.face_pairs(p, 0));
          const double a = first.dot(n);
          const double b = gradient_.row(rest_.face_pairs(p, 1)).dot(n);
          const double jump = b - a;
          const double across = std::max(0.0, first.squaredNorm() - a * a);
          const double wanted = jump + jump_dual_(p);
          // Valleys are negative jumps.
          const double kept = std::max(wanted, -jump_limit(across, 0.5 * (a + b), tan_angle));
          jump_dual_(p) = kJumpLeak * (wanted - kept);
          jump_force_(p) = op_.face_weight(p) *
                           (kConcavity * (kept - jump_dual_(p) - jump) - kSmoothness * jump);
        }
      });
}

void Refinement::project_tets() {
  parallel_for(ctx_.pool, static_cast<std::size_t>(rest_.tet_count()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 ctx_.checkpoint();
                 for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t)
                   force_.row(t) = tet_force(t);
               });
}

// Minus half the derivative of all terms of a tet by its gradient.
Vec3 Refinement::tet_force(Index t) {
  const TetConstraint* c = constraint_of_[t] < 0 ? nullptr : &constraints_[constraint_of_[t]];
  const Vec3 g = gradient_.row(t);
  const Vec3 wanted = g + dual_.row(t).transpose();
  const double length = wanted.norm();
  const Vec3 aim = length > 0 ? Vec3(wanted / length) : build_direction();
  const Vec3 direction = project_to_region(c ? c->hard : machine_, aim).direction;
  const Vec3 kept = std::clamp(direction.dot(wanted), shortest_, longest_) * direction;
  dual_.row(t) = kLeak * (wanted - kept);
  Vec3 force = hard_weight_(t) * (kept - dual_.row(t).transpose() - g) +
               kProximity * op_.volume(t) * (start_gradient_.row(t).transpose() - g);
  if (c && c->soft_weight > 0) force += c->soft_weight * op_.volume(t) * soft_pull(*c, g);
  for (int f = 0; f < 4; ++f) {
    const Index p = op_.pair_across(t, f);
    if (p < 0) continue;
    const double sign = rest_.face_pairs(p, 0) == t ? -1 : 1;
    force += sign * jump_force_(p) * op_.face_normal(p);
  }
  return force;
}

// From g towards what the soft objectives ask for.
Vec3 Refinement::soft_pull(const TetConstraint& constraint, const Vec3& g) const {
  const double size = g.norm();
  const Vec3 target =
      project_to_region(constraint.soft, size > 0 ? Vec3(g / size) : build_direction()).direction;
  const Vec3 pull = std::clamp(target.dot(g), shortest_, longest_) * target - g;
  const double distance = pull.norm();
  const double reach = (constraint.soft.critical ? kStrengthReach : kQualityReach) * usual_;
  const double far = distance / fade_;
  return pull * std::min(1.0, reach / distance) / ((1 + far * far) * (1 + far * far));
}

void Refinement::solve() {
  op_.adjoint(force_, vertex_force_, ctx_);
  pull_supports();
  anchors_.gather_free(vertex_force_, right_);
  change_.setZero();
  solver_->solve(right_, change_, ctx_);
  anchors_.add_free(change_, value_);
}

void Refinement::pull_supports() {
  for (auto& [vertex, support] : supports_) {
    const double rise = value_(vertex) - value_(support.below);
    const double wanted = rise + support.dual;
    const double kept = std::max(wanted, support.rise);
    support.dual = kSupportLeak * (wanted - kept);
    const double force = support.weight * (kept - support.dual - rise);
    vertex_force_(vertex) += force;
    vertex_force_(support.below) -= force;
  }
}

// An island has neighbours in the solid that could be printed before it: the layers shall rise from
// the one that comes first, among those that the machine's tilt allows.
void Refinement::turn_tets_of_minima(const std::vector<std::vector<Index>>& minima) {
  const double steepest = -std::sqrt(1 - cos_tilt_ * cos_tilt_) + kLeastRise;
  for (const std::vector<Index>& minimum : minima) {
    double least = std::numeric_limits<double>::infinity();
    Index from = -1, to = -1;
    for (const Index v : minimum)
      op_.for_each_tet_around(v, [&](Index t) {
        for (int i = 0; i < 4; ++i) {
          const Index u = rest_.tets(t, i);
          if (std::binary_search(minimum.begin(), minimum.end(), u)) continue;
          const Vec3 edge = rest_.vertices.row(v) - rest_.vertices.row(u);
          const double slope = (value_(u) - value_(v)) / edge.norm();
          if (edge.z() < steepest * edge.norm() || slope >= least) continue;
          least = slope;
          from = u;
          to = v;
        }
      });
    if (from >= 0) support_vertex_above(from, to);
  }
}

void Refinement::support_vertex_above(Index from, Index to) {
  const Vec3 rise = (rest_.vertices.row(to) - rest_.vertices.row(from)).normalized();
  op_.for_each_tet_around(to, [&](Index t) {
    bool around = false;
    for (int i = 0; i < 4; ++i) around = around || rest_.tets(t, i) == from;
    if (!around) return;
    if (constraint_of_[t] < 0) {
      constraint_of_[t] = static_cast<Index>(constraints_.size());
      constraints_.push_back({.hard = machine_, .soft = machine_});
    }
    FeasibleRegion& region = constraints_[constraint_of_[t]].hard;
    region.must_rise = true;
    region.rise = rise;
  });
}

// Water that rises from the plate comes to an island over the lowest pass: layers shall rise along
// that way instead. Planar layers rarely have islands, so these are found while they are shallow.
void Refinement::support_minima(const std::vector<std::vector<Index>>& minima) {
  if (minima.empty()) return;
  const Flood flood = flood_from_plate(rest_, op_, objectives_, value_, least_slope_);
  bool changed = false;
  for (const std::vector<Index>& minimum : minima) {
    Index v = minimum.front();
    do {
      const Index below = flood.from[v];
      if (below < 0) break;
      changed = support(v, below) || changed;
      v = below;
    } while (flood.level(v) > value_(v));
  }
  if (changed) prepare_solver();
}

// @return whether that is new
bool Refinement::support(Index vertex, Index below) {
  const auto old = supports_.find(vertex);
  if (old != supports_.end() && old->second.below == below) return false;
  const auto opposite = supports_.find(below);
  if (opposite != supports_.end() && opposite->second.below == vertex) supports_.erase(opposite);
  double volume = 0;  // of the tets around the edge
  op_.for_each_tet_around(vertex, [&](Index t) {
    for (int i = 0; i < 4; ++i)
      if (rest_.tets(t, i) == below) volume += op_.volume(t);
  });
  const double length = (rest_.vertices.row(vertex) - rest_.vertices.row(below)).norm();
  supports_[vertex] = {below, kSupportRise * usual_ * length,
                       kSupport * volume / (length * length)};
  return true;
}

double Refinement::score(Index islands, const Values& omega) const {
  double area = 0, overhang = 0, rough = 0;
  const RegionBounds bounds = region_bounds(params_);
  for (Eigen::Index f = 0; f < objectives_.face_area.size(); ++f) {
    if (objectives_.face_exempt[f]) continue;
    const Vec3 g = gradient_.row(rest_.boundary_face_tet[f]);
    const double cosine = objectives_.face_normal.row(f).dot(g) / g.norm();
    area += objectives_.face_area(f);
    if (cosine < -bounds.sin_alpha) overhang += objectives_.face_area(f);
    if (objectives_.face_wants_quality[f] && std::abs(cosine) > bounds.sin_gamma &&
        std::abs(cosine) < std::cos(kConformalAngle))
      rough += objectives_.face_area(f);
  }
  double stray = 0, critical = 0;
  Index down = 0;
  for (Index t = 0; t < rest_.tet_count(); ++t) {
    const Vec3 g = gradient_.row(t);
    down += g.z() <= 0;
    if (objectives_.critical.empty() || !objectives_.critical[t]) continue;
    critical += 1;
    stray += std::abs(objectives_.tau_max.row(t).dot(g)) > bounds.sin_beta * g.norm();
  }
  const double concave = count_concave_over(omega, kPoorConcaveAngle);
  return bounds.support_free * overhang / area + bounds.surface_quality * rough / area +
         (critical > 0 ? bounds.strength * stray / critical : 0) +
         kConcaveCost * (concave + down) / rest_.tet_count() + kIslandCost * islands;
}

}  // namespace

Values refine_field(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                    const ObjectiveField& objectives, const ObjectiveParams& objective_params,
                    const Values& start, const RefineParams& params, Context& ctx) {
  if (anchors.free_count == 0) return start;
  return Refinement(rest, operators, anchors, objectives, objective_params, start, params, ctx)
      .run();
}

}  // namespace s3
