// Steps (2) to (6) of the paper's overview (Sec. 2.3), by either method, behind one door.
#pragma once
#include <string>
#include <vector>

#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"
#include "params/param_info.h"
#include "scalar_field/islands.h"
#include "scalar_field/scalar_field.h"

namespace s3 {

struct DeformParams {
  std::string method = "refined";
  std::string start = "planar";      // of the method paper with SR
  double rigidity = 1.0;             // w_r of Eq. 12
  double scale_compatibility = 6.0;  // w_c of Eq. 12
  double max_tilt_deg = 90;          // ∇G stays within this angle of z
};

template <class Visitor>
void describe(Visitor& v, DeformParams& p) {
  v(p.method, ParamInfo{.key = "deform.method",
                        .label = "Method",
                        .unit = "",
                        .doc = "refined: short start, then a constrained solve for the field "
                               "itself; paper: the loop of the paper to its stop test.",
                        .choices = {"refined", "paper"},
                        .stage = Stage::outer_loop});
  v(p.start, ParamInfo{.key = "deform.start",
                       .label = "Start",
                       .unit = "",
                       .doc = "First print directions of the method paper where strength is on: "
                              "planar, or heat: away from the plate along the solid (Sec. 5.4.1). "
                              "Along struts under tension planar ends better.",
                       .choices = {"planar", "heat"},
                       .stage = Stage::outer_loop,
                       .advanced = true});
  v(p.rigidity, ParamInfo{.key = "deform.rigidity",
                          .label = "Rigidity",
                          .unit = "",
                          .doc = "Weight w_r of the rigidity term in Eq. 12.",
                          .min = 0,
                          .max = 1e6,
                          .stage = Stage::outer_loop,
                          .advanced = true});
  v(p.scale_compatibility,
    ParamInfo{.key = "deform.scale_compatibility",
              .label = "Scale compatibility",
              .unit = "",
              .doc = "Weight w_c of Eq. 12: how alike neighbouring scales stay.",
              .min = 0,
              .max = 1e6,
              .stage = Stage::outer_loop,
              .advanced = true});
  v(p.max_tilt_deg,
    ParamInfo{
        .key = "deform.max_tilt",
        .label = "Largest tilt",
        .unit = "deg",
        .doc = "Angle from z that the print direction may reach; 0 takes the machine profile's.",
        .min = 0,
        .max = 90,
        .stage = Stage::outer_loop});
}

struct DeformTimings {  // seconds, wall
  double lpd_projection = 0, quaternion = 0, deformation = 0, refinement = 0, foldover = 0;
};

struct DeformResult {
  ScalarField field;                     // G on the rest mesh
  Points deformed;                       // #V×3, M^d, mm: free of foldovers
  Quats rotation;                        // #T×4, q_e
  std::vector<double> residual_history;  // mean Π in rad after each outer iteration
  int outer_iterations = 0;
  std::vector<Island> islands;
  DeformTimings timings;
};

/// Deforms `rest` for the objectives.
/// @param thickness_ratio  d_max/d_min of the layers: bounds how much ‖∇G‖ may vary
/// @throws Error, Cancelled
DeformResult deform(const TetMesh& rest, const ObjectiveField& objectives,
                    const ObjectiveParams& objective_params, const DeformParams& params,
                    double thickness_ratio, Context& ctx);

}  // namespace s3
