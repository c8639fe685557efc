// Zhang et al., "S³-Slicer", ACM TOG 41(6), 2022: Sec. 2.3, steps (2) to (6), and Sec. 4.1.3.
#include "outer_loop/paper_method.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "base/units.h"
#include "deformation/foldover.h"
#include "deformation/scale_controlled.h"
#include "math/rotation.h"
#include "outer_loop/residual.h"
#include "quaternion_field/concavity_weights.h"
#include "quaternion_field/quaternion_field.h"
#include "quaternion_field/rotations_from_deformation.h"
#include "scalar_field/heat_distance.h"
#include "scalar_field/islands.h"

namespace s3 {

namespace {

constexpr int kMaxIterations = 20;
constexpr double kStopChange = 0.05;
constexpr double kLargestExponent = 6;     // of Eq. 11
constexpr double kHeadCone = radians(90);  // θ of Eq. 5, the contract's default
constexpr double kConformalWeight = 10;    // Fig. 5
// Strength of w_k against the smoothness: 0.9 for the paper's Topo-Opt model with its 70k tets.
constexpr double kKeepStrength = 26;

// Factor on w_k that makes Eq. 8 independent of the resolution, of the surface and of the inside.
// With tets of edge h its sum over the pairs tends to 1/h times the integral of |∇q|² over the
// solid, its sum over B to w_k/a times an integral over the surface, a the mean area of a boundary
// face: w_k ~ a/(h L) keeps their ratio, L the size of the solid.
double keep_scale(const TetMesh& rest) {
  const double volume = tet_volumes(rest).sum();
  const double face_area =
      surface_area(boundary_surface(rest)) / static_cast<double>(rest.boundary_faces.rows());
  return kKeepStrength * face_area * std::cbrt(rest.tet_count() / (volume * volume));
}

class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds) {}
  ~Stopwatch() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

struct Iterate {
  Deformation deformation;
  Values omega;  // #N
  double residual = 0;
  Index gouging = 0;

  // Layers that cannot be printed are worse than any residual.
  bool better_than(const Iterate& other) const {
    const bool clear = gouging == 0, other_clear = other.gouging == 0;
    return clear != other_clear ? clear : residual < other.residual;
  }
};

class Loop {
 public:
  Loop(const TetMesh& rest, const ObjectiveField& objectives,
       const ObjectiveParams& objective_params, const DeformParams& params, Context& ctx)
      : rest_(rest),
        objectives_(objectives),
        objective_params_(objective_params),
        ctx_(ctx),
        deformer_(rest, objectives.vertex_on_plate,
                  {.rigidity = params.rigidity, .scale_compatibility = params.scale_compatibility},
                  ctx),
        rotation_(identity_rotations(rest.tet_count())),
        smooth_weight_(Values::Ones(rest.face_pairs.rows())) {
    current_.deformation = undeformed(rest);
    keep_scale_ = keep_scale(rest);
    if (params.start == "heat" && objective_params.strength > 0) start_along_heat();
  }

  Iterate run(DeformResult& result) {
    Iterate best;
    for (int k = 0; k < kMaxIterations; ++k) {
      const bool settled = k > 1 && stops(result.residual_history);
      if (settled && (current_.gouging == 0 || exponent_ >= kLargestExponent)) break;
      iterate(1, result.timings);
      keep(result, best);
      ctx_.progress(Stage::outer_loop, (k + 1.0) / (kMaxIterations + 1));
    }
    if (objective_params_.surface_quality > 0) {
      iterate(kConformalWeight, result.timings);
      keep(result, best);
    }
    return best;
  }

 private:
  // Sec. 5.4.1: the first print directions lead away from the plate along the solid. Not the
  // default: struts are pulled along themselves, where SR wants layers along them; on topopt SR
  // alone ends at 30 % of the critical tets instead of 54 %.
  void start_along_heat() {
    const FieldOperators operators(rest_, ctx_);
    const Directions direction =
        heat_directions(rest_, operators, find_anchors(rest_, objectives_), ctx_);
    for (Index t = 0; t < rest_.tet_count(); ++t)
      rotation_.row(t) = minimal_rotation(direction.row(t), build_direction()).coeffs().transpose();
    align_signs(rest_, rotation_);
    guessed_ = true;
  }

  static bool stops(const std::vector<double>& history) {
    const double before = history[history.size() - 2], now = history.back();
    return std::abs(now - before) <= kStopChange * before;
  }

  void keep(DeformResult& result, Iterate& best) const {
    result.residual_history.push_back(current_.residual);
    ++result.outer_iterations;
    if (result.outer_iterations == 1 || current_.better_than(best)) best = current_;
  }

  // Eq. 11 where the last iterate gouges. Weights never fall again, or the valley would come back
  // with them.
  void adapt_smooth_weights() {
    if (current_.gouging == 0) return;
    exponent_ = std::min(exponent_ + 1, kLargestExponent);
    smooth_weight_ = smooth_weight_.cwiseMax(concavity_weights(current_.omega, exponent_));
  }

  void iterate(double conformal_weight, DeformTimings& timings) {
    RotationField field;
    {
      const Stopwatch watch(timings.quaternion);
      // Step (2); nothing is deformed yet where the directions are a guess.
      if (!std::exchange(guessed_, false))
        rotation_ =
            rotations_from_deformation(rest_, current_.deformation.vertices, rotation_, ctx_);
      // Step (3)
      adapt_smooth_weights();
      const QuaternionFieldParams inner{.tolerance = 1e-2, .conformal_weight = conformal_weight};
      field = optimize_quaternion_field(rest_, objectives_, objective_params_, rotation_,
                                        smooth_weight_, keep_scale_, inner, ctx_);
      rotation_ = field.rotation;
    }
    timings.lpd_projection += field.projection_seconds;
    timings.quaternion -= field.projection_seconds;
    const Stopwatch watch(timings.deformation);
    // Steps (4) and (5)
    current_.deformation = deformer_.deform(rotation_, current_.deformation, ctx_);
    const ScalarField g = make_scalar_field(rest_, current_.deformation.vertices.col(2));
    // Step (6)
    current_.residual = residual(objectives_, objective_params_, g.print_direction, ctx_).mean;
    current_.omega = concave_angles(rest_, g.print_direction);
    current_.gouging = gouging_pairs(current_.omega, kHeadCone);
  }

  const TetMesh& rest_;
  const ObjectiveField& objectives_;
  const ObjectiveParams& objective_params_;
  Context& ctx_;
  ScaleControlledDeformer deformer_;
  Quats rotation_;
  bool guessed_ = false;  // rotation_ is a guess of which no deformation knows
  Values smooth_weight_;
  double keep_scale_ = 1;
  double exponent_ = 0;  // p of Eq. 11; 0 before the first collision
  Iterate current_;
};

void warn_of_gouging(const TetMesh& rest, const ScalarField& field, Context& ctx) {
  const Values omega = concave_angles(rest, field.print_direction);
  const Index count = gouging_pairs(omega, kHeadCone);
  if (count == 0) return;
  std::vector<Vec3> places;
  for (Eigen::Index p = 0; p < omega.size() && places.size() < 100; ++p)
    if (-omega(p) > head_clearance(kHeadCone))
      places.push_back(rest.centroid(rest.face_pairs(p, 0)));
  ctx.warn("outer_loop.gouging",
           std::to_string(count) +
               " neighbouring tets have layers that are concave by more than a "
               "print head of 90° can reach.",
           std::move(places));
}

void warn_of_tilt(const TetMesh& rest, const ScalarField& field, double max_tilt_deg,
                  Context& ctx) {
  // Rounding must not make a warning of a limit that is just met.
  const double least = std::cos(radians(max_tilt_deg)) - 1e-9;
  Index count = 0;
  std::vector<Vec3> places;
  for (Index t = 0; t < rest.tet_count(); ++t) {
    if (field.print_direction(t, 2) >= least) continue;
    ++count;
    if (places.size() < 100) places.push_back(rest.centroid(t));
  }
  if (count == 0) return;
  ctx.warn("outer_loop.tilt",
           "The layers of " + std::to_string(count) + " of " + std::to_string(rest.tet_count()) +
               " tets tilt by more than " + std::to_string(static_cast<int>(max_tilt_deg)) +
               "°. The method 'paper' has no limit for it; use 'refined' for this machine.",
           std::move(places));
}

}  // namespace

DeformResult paper_method(const TetMesh& rest, const ObjectiveField& objectives,
                          const ObjectiveParams& objective_params, const DeformParams& params,
                          Context& ctx) {
  DeformResult result;
  Iterate best = Loop(rest, objectives, objective_params, params, ctx).run(result);
  {
    const Stopwatch watch(result.timings.foldover);
    repair_foldovers(rest, objectives.vertex_on_plate, best.deformation.vertices, ctx);
  }
  result.deformed = std::move(best.deformation.vertices);
  result.field = make_scalar_field(rest, result.deformed.col(2));
  result.rotation =
      rotations_from_deformation(rest, result.deformed, identity_rotations(rest.tet_count()), ctx);
  align_signs(rest, result.rotation);
  result.islands = find_islands(rest, objectives, result.field.value);
  warn_of_gouging(rest, result.field, ctx);
  warn_of_tilt(rest, result.field, params.max_tilt_deg, ctx);
  return result;
}

}  // namespace s3
