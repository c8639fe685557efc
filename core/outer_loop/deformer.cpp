#include "outer_loop/deformer.h"

#include "outer_loop/paper_method.h"
#include "outer_loop/refined_method.h"

namespace s3 {

DeformResult deform(const TetMesh& rest, const ObjectiveField& objectives,
                    const ObjectiveParams& objective_params, const DeformParams& params,
                    double thickness_ratio, Context& ctx) {
  if (params.method == "refined")
    return refined_method(rest, objectives, objective_params, params, thickness_ratio, ctx);
  if (params.method == "paper")
    return paper_method(rest, objectives, objective_params, params, ctx);
  throw Error(ErrorKind::input, Stage::outer_loop, "outer_loop.unknown_method",
              "There is no deformation method '" + params.method + "'",
              "Set deform.method to refined or paper");
}

}  // namespace s3
