#include "pipeline/inspect.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "base/units.h"
#include "mesh/orientation_json.h"
#include "mesh/read_mesh.h"
#include "mesh/repair_parts.h"
#include "mesh/up_axis.h"
#include "mesh/validate.h"
#include "pipeline/places_json.h"
#include "tetrahedralize/quality.h"

namespace s3 {
namespace {

using Json = nlohmann::ordered_json;

Json defect_json(const Defect& defect) {
  return {{"count", defect.count}, {"where", places_json(defect.where)}};
}

Json box_json(const Box& box) {
  const Vec3 size = box.max - box.min;
  return {{"min_mm", {box.min.x(), box.min.y(), box.min.z()}},
          {"max_mm", {box.max.x(), box.max.y(), box.max.z()}},
          {"size_mm", {size.x(), size.y(), size.z()}}};
}

Json surface_json(const MeshReport& report) {
  Json shells = Json::array();
  for (const Shell& shell : report.shells)
    shells.push_back({{"triangles", shell.triangles},
                      {"volume_mm3", shell.volume},
                      {"cavity", shell.depth % 2 == 1},
                      {"inverted", shell.inverted}});
  Json json = box_json(report.box);
  json.update({{"vertices", report.vertices},
               {"triangles", report.triangles},
               {"area_mm2", report.area},
               {"volume_mm3", report.volume},
               {"closed", report.closed()},
               {"valid", report.valid()},
               {"open_edges", defect_json(report.open_edges)},
               {"nonmanifold_edges", defect_json(report.nonmanifold_edges)},
               {"inconsistent_edges", defect_json(report.inconsistent_edges)},
               {"nonmanifold_vertices", defect_json(report.nonmanifold_vertices)},
               {"degenerate_triangles", defect_json(report.degenerate_triangles)},
               {"duplicate_triangles", defect_json(report.duplicate_triangles)},
               {"self_intersections", defect_json(report.self_intersections)},
               {"unused_vertices", report.unused_vertices},
               {"shells", shells}});
  return json;
}

Json orientations_json(const TriMesh& surface, Context& ctx) {
  constexpr std::size_t kListed = 5;
  if (surface.triangles.rows() == 0) return Json::array();
  return to_json(rank_orientations(surface.vertices, surface.triangles,
                                   OrientationGoal::least_support, kListed, &ctx));
}

Json repairs_json(const std::vector<RepairChange>& changes) {
  Json json = Json::array();
  for (const RepairChange& change : changes)
    json.push_back({{"code", change.code},
                    {"sentence", change.sentence},
                    {"count", change.count},
                    {"where", places_json(change.places)}});
  return json;
}

void add_repair(const RepairResult& repaired, Json& json, Context& ctx) {
  json["repairs"] = repairs_json(repaired.changes);
  json["valid_after_repair"] = repaired.valid;
  if (repaired.valid)
    json["volume_after_repair_mm3"] = repaired.report.volume;
  else
    json["rebuild_reason"] = repaired.reason;
  json["mesher"] = repaired.valid ? "tetgen" : "stuffing";
  json["orientations"] = orientations_json(repaired.surface, ctx);
}

// What the file holds, what repair would do about it, and which mesher would take the result.
Json inspect_surface_file(const ModelFile& file, Context& ctx) {
  const TriMesh& surface = file.surface;
  Json json = surface_json(inspect_surface(surface, &ctx));
  warn_about_units(bounding_box(surface.vertices), ctx);
  warn_about_up_axis(surface, {}, ctx);
  try {
    add_repair(repair_parts(surface, file.part_of_triangle, ctx), json, ctx);
  } catch (const Error& error) {  // what is wrong is the answer here
    json["refused"] = std::string(error.what()) + "; " + error.hint;
  }
  return json;
}

Json inspect_volume_file(ModelFile file, Context& ctx) {
  const TetMesh mesh = make_tet_mesh(std::move(file.vertices), std::move(file.tets));
  const TriMesh surface = boundary_surface(mesh);
  const TetQuality quality = tet_quality(mesh);
  warn_about_units(bounding_box(mesh.vertices), ctx);
  warn_about_up_axis(surface, {}, ctx);
  Json json = box_json(bounding_box(mesh.vertices));
  json.update({{"vertices", mesh.vertex_count()},
               {"tets", mesh.tet_count()},
               {"boundary_faces", mesh.boundary_faces.rows()},
               {"area_mm2", surface_area(surface)},
               {"volume_mm3", enclosed_volume(surface)},
               {"min_dihedral_deg", degrees(quality.min_dihedral)},
               {"max_dihedral_deg", degrees(quality.max_dihedral)},
               {"tets_below_10_deg", quality.tets_below_10_deg},
               {"orientations", orientations_json(surface, ctx)}});
  return json;
}

}  // namespace

Json inspect_model(std::span<const std::byte> bytes, const std::string& file_name, Context& ctx) {
  ModelFile file = read_model(bytes, file_name);
  ctx.warnings = std::move(file.warnings);
  Json json = {{"file", file_name}, {"format", file.format}, {"is_volume", file.is_volume}};
  if (file.part_names.size() > 1) json["parts"] = file.part_names;
  json.update(file.is_volume ? inspect_volume_file(std::move(file), ctx)
                             : inspect_surface_file(file, ctx));
  Json warnings = Json::array();
  for (const Warning& warning : ctx.warnings) warnings.push_back(warning.message);
  ctx.warnings.clear();
  json["warnings"] = warnings;
  return json;
}

}  // namespace s3
