#include "outer_loop/deformer.h"

#include "outer_loop/refined_method.h"

namespace s3 {

DeformResult deform(const TetMesh& rest, const ObjectiveField& objectives,
                    const ObjectiveParams& objective_params, const DeformParams& params,
                    double thickness_ratio, Context& ctx) {
  if (params.method == "paper")
    throw Error(ErrorKind::slicing, Stage::outer_loop, "outer_loop.no_method",
                "the method \"paper\" is not part of this build", "use deform.method refined");
  return refined_method(rest, objectives, objective_params, params, thickness_ratio, ctx);
}

}  // namespace s3
