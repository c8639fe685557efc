#include "toolpaths/make_toolpaths.h"

#include <cmath>
#include <utility>

#include "toolpaths/contour_parallel.h"
#include "toolpaths/coverage.h"
#include "toolpaths/hole_filler.h"
#include "toolpaths/hybrid.h"
#include "toolpaths/line_quality.h"
#include "toolpaths/path_order.h"

namespace s3 {
namespace {

constexpr double kLeastCritical = 0.01;  // of the area in S, for a layer to pass through S

struct PlannedLayer {
  LayerPaths measured;  // without the paths
  PathTree tree;
};

LayerMesh mesh_of(const Layer& layer) {
  return {layer.surface.vertices, layer.normal, layer.bead_height, layer.surface.triangles};
}

/// Measured on the layer as it came: its vertices are the first of the refined ones. Together with
/// the medial axis they are dense enough to tell where it is wide.
Coverage measure(const Layer& layer, const ContourPlan& plan, const std::vector<Path>& paths,
                 double width, const Context& ctx) {
  const LayerMesh mesh = mesh_of(layer);
  const Values distance = plan.work.field.distance.head(mesh.vertices.rows());
  std::vector<InnerDisc> discs;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    if (std::isfinite(distance(v))) discs.push_back({mesh.vertices.row(v), distance(v)});
  for (std::size_t i = 0; i < plan.axis.nodes.size(); i += 2)
    discs.push_back({plan.axis.nodes[i].point, plan.axis.nodes[i].radius});
  return measure_coverage(mesh, distance, discs, paths, width, kLeastBeadWidth * width, ctx);
}

void measure_paths(const Layer& layer, const ContourPlan& plan, const LayerStress* followed,
                   double width, LayerPaths& measured, const Context& ctx) {
  std::vector<Path> paths;
  paths.reserve(plan.paths.size());
  for (const PlannedPath& p : plan.paths) paths.push_back(p.path);
  if (followed) measured.lines = measure_lines(mesh_of(layer), *followed, paths, width, ctx);
  const Coverage coverage = measure(layer, plan, paths, width, ctx);
  measured.area = coverage.area;
  measured.covered_area = coverage.covered;
  measured.overlap_area = coverage.overlap;
  measured.wide_area = coverage.wide;
  measured.unfilled_thin_area = coverage.thin;
}

/// @param stress  null for a contour-parallel layer
PlannedLayer plan_layer(const Layer& layer, const StressField* stress, double width, int walls,
                        PathFigures figures, const Context& ctx) {
  PlannedLayer result;
  ContourPlan plan = plan_contours(mesh_of(layer), width, ctx);
  if (plan.work.boundary.size() == 0) {
    result.measured.area = result.measured.unfilled_thin_area = surface_area(layer.surface);
    return result;
  }
  LayerStress projected;
  if (stress) projected = project_stress(layer, *stress);
  const bool hybrid = stress && critical_share(layer, projected) >= kLeastCritical;
  if (hybrid) fill_with_lines(projected, width, walls, plan, ctx);
  fill_holes(plan.work, plan.field.coordinate, plan.axis, width, plan.paths);
  if (figures == PathFigures::measured)
    measure_paths(layer, plan, hybrid ? &projected : nullptr, width, result.measured, ctx);
  result.tree = nest_paths(plan.work, plan.field.coordinate, std::move(plan.paths));
  return result;
}

LayerPaths order_alone(const Layer& layer, PlannedLayer planned) {
  LayerPaths result = std::move(planned.measured);
  const Vec3 start =
      layer.surface.vertices.rows() > 0 ? Vec3(layer.surface.vertices.row(0)) : Vec3(Vec3::Zero());
  result.paths = order_paths(planned.tree, start);
  return result;
}

/// Orders the layers' paths one after the other, in print order.
Toolpaths order_stack(const LayerStack& stack, std::vector<PlannedLayer> planned, Context& ctx) {
  Toolpaths result;
  Vec3 seam = Vec3::Zero();
  double area = 0, thin_area = 0;
  std::vector<Vec3> empty;  // places of components without any path
  for (std::size_t i = 0; i < planned.size(); ++i) {
    LayerPaths layer = std::move(planned[i].measured);
    layer.component = static_cast<Index>(i);
    layer.paths = order_paths(planned[i].tree, seam);
    if (!layer.paths.empty()) seam = layer.paths.front().points.row(0);
    area += layer.area;
    if (layer.unfilled_thin_area > 0) {
      thin_area += layer.unfilled_thin_area;
      if (layer.paths.empty() && stack.layers[i].surface.vertices.rows() > 0)
        empty.push_back(stack.layers[i].surface.vertices.row(0));
    }
    result.layers.push_back(std::move(layer));
  }
  constexpr double kWorthAWarning = 0.002;  // of the whole area
  if (thin_area > kWorthAWarning * area)
    ctx.warn("toolpaths.thin_area",
             std::to_string(thin_area) + " mm² of " + std::to_string(area) +
                 " mm² of layers are too thin for a bead and stay empty; " +
                 std::to_string(empty.size()) +
                 " layer components have no path at all. A narrower toolpath.width fills more.",
             empty);
  return result;
}

}  // namespace

LayerPaths contour_parallel(const Layer& layer, double width, const Context& ctx) {
  return order_alone(layer, plan_layer(layer, nullptr, width, 1, PathFigures::measured, ctx));
}

LayerPaths hybrid_parallel(const Layer& layer, const StressField& stress, double width, int walls,
                           const Context& ctx) {
  return order_alone(layer, plan_layer(layer, &stress, width, walls, PathFigures::measured, ctx));
}

Toolpaths make_toolpaths(const LayerStack& stack, const StressField* stress,
                         const ToolpathParams& params, double nozzle_diameter, Context& ctx,
                         PathFigures figures) {
  const double width = params.width > 0 ? params.width : nozzle_diameter;
  if (!(width > 0) || !std::isfinite(width))
    throw Error(ErrorKind::input, Stage::toolpaths, "toolpaths.bad_width",
                "The bead width must be a positive length, not " + std::to_string(width) + " mm.",
                "Set toolpath.width or nozzle.diameter.");
  const StressField* followed = params.strategy == "hybrid" ? stress : nullptr;
  const std::size_t n = stack.layers.size();
  std::vector<PlannedLayer> planned(n);
  // In blocks, so that progress and cancel are seen from the stage's own thread.
  constexpr std::size_t kBlock = 16;
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t end = std::min(n, begin + kBlock);
    parallel_for(ctx.pool, end - begin, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = begin + first; i < begin + last; ++i)
        planned[i] = plan_layer(stack.layers[i], followed, width, params.walls, figures, ctx);
    });
    ctx.progress(Stage::toolpaths, static_cast<double>(end) / static_cast<double>(n));
  }
  return order_stack(stack, std::move(planned), ctx);
}

}  // namespace s3
