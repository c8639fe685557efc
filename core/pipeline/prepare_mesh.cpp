#include "pipeline/prepare_mesh.h"

#include <cstdio>
#include <utility>

#include "base/error.h"
#include "mesh/parts.h"
#include "mesh/placement.h"
#include "mesh/reorder.h"
#include "mesh/repair.h"
#include "mesh/repair_parts.h"
#include "mesh/thicken_sheet.h"
#include "mesh/up_axis.h"
#include "mesh/validate.h"
#include "tetrahedralize/tetrahedralize.h"

namespace s3 {
namespace {

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> inverse(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    inverse[static_cast<std::size_t>(order[i])] = static_cast<Index>(i);
  return inverse;
}

}  // namespace

void prepare_volume(ModelFile file, const InputParams& params, Artifacts& artifacts, Context& ctx) {
  TetMesh mesh = make_tet_mesh(std::move(file.vertices), std::move(file.tets));
  warn_about_up_axis(boundary_surface(mesh), params, ctx);
  artifacts.placement =
      placement(mesh.vertices, mesh.boundary_faces, params, &artifacts.model.orientations, &ctx);
  transform_points(artifacts.placement, mesh.vertices);
  std::vector<Index> vertex_order, tet_order;
  artifacts.rest = reorder_along_morton(mesh, &vertex_order, &tet_order);
  artifacts.file_order = {inverse(vertex_order), inverse(tet_order)};
  artifacts.surface = boundary_surface(artifacts.rest);
  warn_about_units(bounding_box(artifacts.surface.vertices), ctx);
  artifacts.model.triangles = static_cast<Index>(artifacts.surface.triangles.rows());
  artifacts.model.volume = enclosed_volume(artifacts.surface);
  artifacts.filling = {"file", {}, false, {}, 0};
}

namespace {

bool is_sheet(const Error& error) {
  return error.code == "mesh.open_surface" || error.code == "mesh.no_volume";
}

RepairResult repaired_surface(ModelFile& file, const InputParams& params, Context& ctx) {
  try {
    return repair_parts(file.surface, file.part_of_triangle, ctx);
  } catch (const Error& error) {
    if (!is_sheet(error) || params.sheet_thickness <= 0) throw;
  }
  RepairResult made =
      repair_surface(thicken_sheet(file.surface, params.sheet_thickness / params.scale), ctx);
  char text[100];
  std::snprintf(text, sizeof text, "The surface encloses nothing; it was made %.4g mm thick",
                params.sheet_thickness);
  ctx.warn("mesh.thickened", text);
  made.changes.insert(made.changes.begin(), {"repair.thickened", text, 1, {}});
  return made;
}

}  // namespace

void prepare_surface(ModelFile file, const InputParams& params, Artifacts& artifacts,
                     Context& ctx) {
  artifacts.model.triangles = static_cast<Index>(file.surface.triangles.rows());
  InputParams input = params;
  std::vector<Orientation> of_parts;
  if (file.part_names.size() > 1)
    input =
        stand_parts(file.surface, file.part_of_triangle, file.part_names, params, of_parts, ctx);
  RepairResult repaired = repaired_surface(file, params, ctx);
  artifacts.model.repairs = std::move(repaired.changes);
  artifacts.model.defect = std::move(repaired.reason);
  TriMesh surface = std::move(repaired.surface);
  warn_about_up_axis(surface, input, ctx);
  artifacts.placement =
      placement(surface.vertices, surface.triangles, input, &artifacts.model.orientations, &ctx);
  if (!of_parts.empty()) artifacts.model.orientations = std::move(of_parts);
  transform_points(artifacts.placement, surface.vertices);
  warn_about_units(bounding_box(surface.vertices), ctx);
  if (artifacts.model.defect.empty()) artifacts.model.volume = enclosed_volume(surface);
  artifacts.surface = surface;
  artifacts.given = std::move(surface);
}

namespace {

[[noreturn]] void throw_no_volume() {
  throw Error(ErrorKind::input, Stage::tetrahedralize, "mesh.no_volume",
              "The triangles enclose no volume: nowhere are more of them in front of a point than "
              "behind it",
              "Close the surface and let its triangles face outward, or give sheets a thickness");
}

Tetrahedralization tets_of(const Artifacts& artifacts, const TetrahedralizeParams& params,
                           Context& ctx) {
  try {
    return tetrahedralize(artifacts.given, params, ctx, artifacts.model.defect);
  } catch (const Error& error) {
    if (error.code == "tetrahedralize.empty") throw_no_volume();
    throw;
  }
}

void warn_about_rebuild(const Filling& filling, Context& ctx) {
  const DistanceFigures &to = filling.distance.from_made, &back = filling.distance.from_given;
  const bool worst_back = back.max > to.max;
  char text[240];
  std::snprintf(text, sizeof text,
                "The solid was %s the triangles: 95 %% of its surface is within %.3g mm of theirs "
                "(%.2g %% of the diagonal), the farthest point %.3g mm away",
                filling.backend == "tetgen" ? "simplified from" : "rebuilt from",
                filling.distance.p95(), 100 * filling.distance.p95() / filling.diagonal,
                filling.distance.max());
  ctx.warn("mesh.rebuilt", text, {worst_back ? back.place : to.place});
}

}  // namespace

void fill_surface(const TetrahedralizeParams& params, Artifacts& artifacts, Context& ctx) {
  Tetrahedralization made = tets_of(artifacts, params, ctx);
  artifacts.rest = std::move(made.mesh);
  artifacts.file_order = {};
  Filling& filling = artifacts.filling;
  filling = {made.backend, made.fallback, made.approximated, {}, 0};
  filling.diagonal = bounding_box(artifacts.given.vertices).diagonal();
  artifacts.surface = artifacts.given;
  if (!filling.rebuilt) return;
  const TriMesh boundary = boundary_surface(artifacts.rest);
  const WindingNumber solid(artifacts.given);
  filling.distance = surface_distance(boundary, artifacts.given, &solid, ctx);
  warn_about_rebuild(filling, ctx);
  if (artifacts.model.defect.empty()) return;  // the given surface stays the measure
  artifacts.model.volume = enclosed_volume(boundary);
  artifacts.surface = boundary;
}

}  // namespace s3
