#include "pipeline/evaluate.h"

#include "base/error.h"
#include "base/units.h"
#include "metrics/print_metrics.h"
#include "metrics/strain.h"
#include "metrics/support_volume.h"
#include "metrics/thickness.h"
#include "outer_loop/residual.h"
#include "quaternion_field/concavity_weights.h"
#include "scalar_field/islands.h"

namespace s3 {
namespace {

/// A verification that cannot be finished costs its figures, not the run.
void measure_strain(const Artifacts& artifacts, const Waypoints& waypoints, Evaluation& evaluation,
                    Context& ctx) {
  try {
    const Values strain = printed_strain(artifacts.rest, waypoints, *artifacts.load_cases, ctx);
    const Values volume = tet_volumes(artifacts.rest);
    evaluation.metrics.strain = strain_figures(strain, volume);
    for (Eigen::Index t = 0; t < strain.size(); ++t)
      evaluation.plots.strain.push_back({strain[t], volume[t]});
  } catch (const Error& error) {
    ctx.warn("metrics.no_strain", std::string("No strain of the print: ") + error.what());
  }
}

}  // namespace

Evaluation evaluate_field(const Artifacts& a, const ScalarField& field, const Points& deformed,
                          const Params& params, const MachineProfile& machine, Context& ctx) {
  constexpr double kConcaveDeg = 20;
  Evaluation out;
  Metrics& m = out.metrics;
  const Directions& directions = field.print_direction;
  out.plots.angles = lpd_angles(a.rest, a.objectives, a.stress ? &*a.stress : nullptr, directions);
  lpd_metrics(out.plots.angles, m);
  m.pi_rad = residual(a.objectives, params.objectives, directions, ctx).mean;
  m.foldovers = count_foldovers(deformed, a.rest.tets);
  const Values omega = concave_angles(a.rest, directions);
  m.gouging_pairs = gouging_pairs(omega, machine.head_cone_angle);
  m.concave_pairs_over_20deg = count_concave_over(omega, radians(kConcaveDeg));
  m.islands = static_cast<int>(find_islands(a.rest, a.objectives, field.value).size());
  m.support_volume_mm3 = support_volume(a.rest, a.objectives, directions, ctx);
  return out;
}

void evaluate_print(const Artifacts& artifacts, const Print& print, const Params& params,
                    const MachineProfile& machine, Evaluation& evaluation, Context& ctx) {
  Metrics& m = evaluation.metrics;
  layer_metrics(print.layers, params.layers.min_thickness, params.layers.max_thickness, m, ctx);
  evaluation.plots.thickness = thickness_values(print.layers);
  toolpath_metrics(print.toolpaths, m);
  waypoint_metrics(print.waypoints, machine, m);
  surface_error(artifacts.surface, print.waypoints, m, ctx);
  if (artifacts.load_cases && m.path_length_mm.value_or(0) > 0)
    measure_strain(artifacts, print.waypoints, evaluation, ctx);
}

}  // namespace s3
