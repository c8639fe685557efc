#include "pipeline/params.h"

#include <cstdio>
#include <string>

#include "base/error.h"
#include "base/units.h"
#include "params/param_visitors.h"

namespace s3 {
namespace {

constexpr int kFewestTets = 100;  // apart from 0

}  // namespace

Params resolve(const Params& params, const MachineProfile& machine) {
  Params resolved = params;
  check_ranges(list_params(resolved));
  if (resolved.mesh.target_tets > 0 && resolved.mesh.target_tets < kFewestTets)
    throw Error(ErrorKind::input, Stage::tetrahedralize, "params.out_of_range",
                "mesh.target_tets is " + std::to_string(resolved.mesh.target_tets) + ", below " +
                    std::to_string(kFewestTets),
                "0 takes the number that the model's walls need");
  if (resolved.deform.max_tilt_deg == 0) resolved.deform.max_tilt_deg = degrees(machine.max_tilt);
  resolved.layers.min_thickness = params.layers.d_min();
  resolved.layers.max_thickness = params.layers.d_max();
  if (resolved.toolpath.width == 0) resolved.toolpath.width = params.layers.nozzle_diameter;
  if (resolved.layers.min_thickness >= resolved.layers.max_thickness) {
    char message[160];
    std::snprintf(message, sizeof message,
                  "layers.min_thickness is %g mm, not below layers.max_thickness of %g mm",
                  resolved.layers.min_thickness, resolved.layers.max_thickness);
    throw Error(ErrorKind::input, Stage::layers, "params.out_of_range", message,
                "0 takes 0.4 and 1.0 times nozzle.diameter");
  }
  const ObjectiveParams& o = resolved.objectives;
  if (o.support_free == 0 && o.strength == 0 && o.surface_quality == 0)
    throw Error(
        ErrorKind::input, Stage::objectives, "params.out_of_range",
        "all weights of the objectives are 0",
        "set objectives.support_free, objectives.strength or objectives.surface_quality above 0");
  return resolved;
}

}  // namespace s3
