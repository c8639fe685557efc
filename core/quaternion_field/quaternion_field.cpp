// Sec. 3.2: local projection and global blending of the quaternion field (Eqs. 8 and 9).
#include "quaternion_field/quaternion_field.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "math/rotation.h"
#include "quaternion_field/face_laplacian.h"
#include "quaternion_field/rotations_from_deformation.h"

namespace s3 {

namespace {

constexpr double kPlateHold = 10;
// Ties every tet weakly to where it is: a component without any target would make the matrix
// singular.
constexpr double kAnchor = 1e-6;
// A target this close to a face's normal is the conformal choice of H_SQ.
constexpr double kConformalCosine = 1 - 1e-9;

// U_SF, U_SQ, U_SR and their weights in one: Eq. 9.
double keep_weight(const FeasibleRegion& region, const Vec3& d) {
  const RegionBounds& b = region.bounds;
  double weight = region.critical ? b.strength : 0;
  for (int i = 0; i < region.face_count; ++i) {
    const auto& face = region.faces[static_cast<std::size_t>(i)];
    const double cosine = face.normal.dot(d);
    if (cosine + b.sin_alpha < 0) weight = std::max(weight, b.support_free);
    if (face.quality && std::abs(cosine) > b.sin_gamma && std::abs(cosine) < kConformalCosine)
      weight = std::max(weight, b.surface_quality);
  }
  return weight;
}

bool is_conformal(const FeasibleRegion& region, const Vec3& d) {
  for (int i = 0; i < region.face_count; ++i) {
    const auto& face = region.faces[static_cast<std::size_t>(i)];
    if (face.quality && std::abs(face.normal.dot(d)) >= kConformalCosine) return true;
  }
  return false;
}

// The tets that have a target, with their regions.
struct HeldTets {
  std::vector<Index> tet;
  std::vector<FeasibleRegion> region;
  std::size_t size() const { return tet.size(); }
};

HeldTets held_tets(const ObjectiveField& objectives, const RegionBounds& bounds,
                   const Values& weight) {
  HeldTets held;
  for (Index t = 0; t < weight.size(); ++t) {
    if (weight(t) <= 0) continue;
    held.tet.push_back(t);
    held.region.push_back(feasible_region(objectives, bounds, t));
  }
  return held;
}

// Local step: q^t = q ∘ r with r the minimal rotation that takes the closest feasible direction to
// d, so R(q^t) d_c = d_p. The scalar part of r is never negative, so q^t has the sign of q.
int project_targets(const HeldTets& held, const Block& rotation, Quats& target,
                    std::vector<char>& conformal, Context& ctx) {
  constexpr std::size_t kGrain = 512;
  return parallel_sum(ctx.pool, held.size(), kGrain, 0, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    int infeasible = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const Index t = held.tet[i];
      const Eigen::RowVector4d q = rotation.row(t);
      const Vec3 d = print_direction_of(q);
      const Projection closest = project_to_region(held.region[i], d);
      infeasible += !closest.feasible;
      conformal[i] = is_conformal(held.region[i], closest.direction);
      const Quat turned = Quat(q(3), q(0), q(1), q(2)) * minimal_rotation(closest.direction, d);
      target.row(t) = turned.coeffs().normalized();
    }
    return infeasible;
  });
}

void normalise_rows(Block& x, const Quats& fallback, Context& ctx) {
  parallel_for(ctx.pool, static_cast<std::size_t>(x.rows()), 16384,
               [&](std::size_t begin, std::size_t end) {
                 for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t) {
                   const double length = x.row(t).norm();
                   // Opposite quaternions cancel in a blend; such a tet keeps its rotation.
                   constexpr double kVanished = 1e-6;
                   if (length > kVanished)
                     x.row(t) /= length;
                   else
                     x.row(t) = fallback.row(t);
                 }
               });
}

}  // namespace

Values keep_weights(const ObjectiveField& objectives, const RegionBounds& bounds,
                    const Quats& rotation, Context& ctx) {
  Values weight(rotation.rows());
  parallel_for(ctx.pool, static_cast<std::size_t>(rotation.rows()), 4096,
               [&](std::size_t begin, std::size_t end) {
                 for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t) {
                   const FeasibleRegion region = feasible_region(objectives, bounds, t);
                   weight(t) = region.on_plate ? kPlateHold : 0;
                   if (!region.on_plate && region.constrained())
                     weight(t) = keep_weight(region, print_direction_of(rotation.row(t)));
                 }
               });
  return weight;
}

RotationField optimize_quaternion_field(const TetMesh& rest, const ObjectiveField& objectives,
                                        const ObjectiveParams& objective_params,
                                        const Quats& rotation, const Values& smooth_weight,
                                        double keep_scale, const QuaternionFieldParams& params,
                                        Context& ctx) {
  RotationField field;
  field.rotation = rotation;
  align_signs(rest, field.rotation);
  field.target_rotation = field.rotation;

  // The switches see the margin too: a satisfied tet within the margin would be let go, and fall
  // back behind its bound in the next outer iteration.
  const RegionBounds bounds = region_bounds(objective_params, params.alpha_margin);
  Values hold = keep_scale * keep_weights(objectives, bounds, rotation, ctx);
  const HeldTets held = held_tets(objectives, bounds, hold);
  Block x = field.rotation;
  std::vector<char> conformal(held.size(), 0);
  const auto project = [&] {
    const auto start = std::chrono::steady_clock::now();
    field.infeasible_tets = project_targets(held, x, field.target_rotation, conformal, ctx);
    field.projection_seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  project();
  for (std::size_t i = 0; i < held.size(); ++i)
    if (conformal[i]) hold(held.tet[i]) *= params.conformal_weight;
  hold.array() += kAnchor;

  const auto solver = make_solver({.tolerance = params.tolerance});
  solver->factor(face_laplacian(rest, smooth_weight, hold), ctx);
  Block b(rest.tet_count(), 4);
  for (int iteration = 0; iteration < params.inner_iterations; ++iteration) {
    if (iteration > 0) project();
    b = hold.asDiagonal() * field.target_rotation;
    solver->solve(b, x, ctx);
    normalise_rows(x, field.rotation, ctx);
    ctx.progress(Stage::quaternion_field, (iteration + 1.0) / params.inner_iterations);
  }
  field.rotation = x;
  project();
  return field;
}

}  // namespace s3
