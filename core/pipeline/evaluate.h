// All figures of one print (Sec. 5.2): the same for curved layers and for the planar baseline.
#pragma once
#include "base/context.h"
#include "metrics/histograms.h"
#include "metrics/metrics.h"
#include "motion/machine_profile.h"
#include "pipeline/artifacts.h"
#include "pipeline/params.h"

namespace s3 {

struct Evaluation {
  Metrics metrics;
  PlotData plots;
};

/// What follows from the field alone: angles, Π, foldovers, concave pairs, islands, support volume.
/// @param artifacts  the mesh, stress and objectives of it
/// @param deformed   #V×3, M^d
Evaluation evaluate_field(const Artifacts& artifacts, const ScalarField& field,
                          const Points& deformed, const Params& params,
                          const MachineProfile& machine, Context& ctx);

/// Adds what follows from layers, toolpaths and waypoints.
void evaluate_print(const Artifacts& artifacts, const Print& print, const Params& params,
                    const MachineProfile& machine, Evaluation& evaluation, Context& ctx);

}  // namespace s3
