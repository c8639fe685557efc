#include "tetrahedralize/fill_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "base/units.h"
#include "mesh/refine_surface.h"
#include "mesh/validate.h"
#include "tetrahedralize/coarsen_surface.h"
#include "tetrahedralize/quality.h"
#include "tetrahedralize/tetgen_backend.h"

namespace s3 {

namespace {

// Tolerances of the tries, as shares of a tet's edge and at most a share of the model's diagonal. 0
// keeps the surface.
constexpr std::array<double, 4> kTolerances = {0, 0.01, 0.025, 0.05};
constexpr double kMostOfDiagonal = 0.002;
// From this smallest dihedral angle on no other try is needed; a looser one must be better by this
// factor to be taken.
constexpr double kGoodAngle = radians(1);
constexpr double kWorthwhile = 1.25;
// How many more tets than wanted are as good as the wanted number, and how many are too many.
constexpr double kCountTolerance = 0.15;
constexpr double kTooMany = 1.5;

struct Attempt {
  TetMesh mesh;
  double angle = -1;  // the smallest dihedral angle, rad; negative: not made
  double tolerance = 0;
  std::vector<Warning> warnings;

  bool is_made() const { return angle >= 0; }
  double excess(int target_tets) const {
    return mesh.tet_count() / static_cast<double>(target_tets);
  }
  bool is_good(int target_tets) const {
    return is_made() && angle >= kGoodAngle && excess(target_tets) <= 1 + kCountTolerance;
  }
};

bool is_better(const Attempt& loose, const Attempt& tight, int target_tets) {
  if (!loose.is_made() || !tight.is_made()) return loose.is_made();
  const double a = loose.excess(target_tets), b = tight.excess(target_tets);
  if (std::max(a, b) > kTooMany) return a < b;
  return loose.angle > kWorthwhile * tight.angle || loose.is_good(target_tets);
}

double least_tets(const TriMesh& surface) {
  return kTetsPerTriangle * static_cast<double>(surface.triangles.rows());
}

// The surface with triangles of about a wanted size, within a tolerance.
TriMesh prepared(const TriMesh& surface, double edge, double tolerance, const Context& ctx) {
  // Needles go first, lest they be split; what the splits make of long ones goes afterwards.
  const TriMesh coarse = coarsen_surface(surface, edge, tolerance, ctx);
  return coarsen_surface(refine_surface(coarse, edge), edge, tolerance, ctx);
}

// @return without triangles when the simplified surface is no border of a solid, or too small
TriMesh simplified(const TriMesh& surface, double edge, double& tolerance, const Context& ctx) {
  constexpr double kVolumeSlack = 0.008;
  const double volume = enclosed_volume(surface);
  for (int i = 0; i < 4; ++i, tolerance *= 0.7) {
    TriMesh coarse = prepared(surface, edge, tolerance, ctx);
    if (inspect_surface(coarse, &ctx).valid() &&
        std::abs(enclosed_volume(coarse) - volume) <= kVolumeSlack * volume)
      return coarse;
  }
  return {};
}

// @return not made when the simplified surface is no border of a solid, or still too fine by far
// @throws Error as fill_with_tetgen()
Attempt make_attempt(const TriMesh& surface, int target_tets, double share, Context& ctx) {
  constexpr int kMaxTries = 3;
  double edge = target_edge_for(surface, target_tets);
  Attempt attempt;
  attempt.tolerance =
      std::min(share * edge, kMostOfDiagonal * bounding_box(surface.vertices).diagonal());
  for (int i = 1;; ++i) {
    const bool exact = share == 0, is_last = share == kTolerances.back();
    const TriMesh ready =
        exact ? refine_surface(surface, edge) : simplified(surface, edge, attempt.tolerance, ctx);
    if (ready.triangles.rows() == 0) return {};
    if (!exact && !is_last && least_tets(ready) > target_tets) return {};

    const std::vector<Warning> warnings = ctx.warnings;
    try {
      attempt.mesh = fill_with_tetgen(ready, target_tets, ctx);
    } catch (...) {
      ctx.warnings = warnings;
      throw;
    }
    attempt.warnings.assign(ctx.warnings.begin() + static_cast<std::ptrdiff_t>(warnings.size()),
                            ctx.warnings.end());
    ctx.warnings = warnings;
    // Where split triangles force more tets than wanted, as on thin parts, larger ones are tried.
    const bool was_split = ready.triangles.rows() > surface.triangles.rows();
    if (attempt.excess(target_tets) <= 1 + kCountTolerance || !was_split || i == kMaxTries) break;
    edge *= std::sqrt(attempt.excess(target_tets));
  }
  attempt.angle = tet_quality(attempt.mesh).min_dihedral;
  return attempt;
}

void warn_about_simplification(const TriMesh& surface, int target_tets, const Attempt& taken,
                               double exact_angle, Context& ctx) {
  char why[128], text[320];
  if (exact_angle < 0)
    std::snprintf(why, sizeof why, "its %ld triangles are too many for %d tets",
                  static_cast<long>(surface.triangles.rows()), target_tets);
  else
    std::snprintf(why, sizeof why, "its own triangles force tets with angles of %.2g°",
                  degrees(exact_angle));
  std::snprintf(text, sizeof text, "The surface was simplified, by about %.2g mm at most: %s",
                taken.tolerance, why);
  ctx.warn("tetrahedralize.simplified", text);
}

}  // namespace

SolidFilling fill_solid(const TriMesh& surface, int target_tets, Context& ctx) {
  Attempt best;
  double exact_angle = -1;
  std::exception_ptr failure;
  // Too many triangles are not even tried: TetGen would be long at it. Unless there is nothing
  // else.
  const bool too_fine = least_tets(surface) > kTooMany * target_tets;
  for (const double share : kTolerances) {
    if (share == 0 && too_fine) continue;
    try {
      Attempt attempt = make_attempt(surface, target_tets, share, ctx);
      if (share == 0) exact_angle = attempt.angle;
      if (is_better(attempt, best, target_tets)) best = std::move(attempt);
    } catch (const Error& error) {
      if (error.code == "tetrahedralize.empty") throw;
      if (!failure) failure = std::current_exception();
    }
    if (best.is_good(target_tets)) break;
  }
  if (!best.is_made() && too_fine) best = make_attempt(surface, target_tets, 0, ctx);
  if (!best.is_made()) std::rethrow_exception(failure);

  ctx.warnings.insert(ctx.warnings.end(), best.warnings.begin(), best.warnings.end());
  const bool approximated = best.tolerance > 0;
  if (approximated) warn_about_simplification(surface, target_tets, best, exact_angle, ctx);
  return {std::move(best.mesh), approximated};
}

}  // namespace s3
