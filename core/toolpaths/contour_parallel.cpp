#include "toolpaths/contour_parallel.h"

#include <iterator>
#include <utility>

#include "toolpaths/axis_beads.h"
#include "toolpaths/simplify.h"

namespace s3 {

ContourPlan plan_contours(LayerMesh mesh, double width, const Context& ctx) {
  ContourPlan plan;
  plan.work = prepare_layer(std::move(mesh), width, ctx);
  if (plan.work.boundary.size() == 0) return plan;
  const MedialPlan medial(plan.work, width, ctx);
  plan.axis = medial.axis();
  plan.field = make_bead_field(plan.work, medial, width);
  plan.paths = trace_rings(plan.work, plan.field);
  std::vector<PlannedPath> beads = axis_beads(plan.axis, width);
  drop_rings_on_beads(plan.paths, beads, width);
  std::move(beads.begin(), beads.end(), std::back_inserter(plan.paths));
  for (PlannedPath& p : plan.paths) simplify(p.path, kSimplifyPath * width);
  return plan;
}

}  // namespace s3
