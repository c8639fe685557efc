#include <cstdio>
#include <limits>

#include <nlohmann/json.hpp>

#include "base/units.h"
#include "commands.h"
#include "files.h"
#include "mesh/orientation_json.h"
#include "mesh/read_mesh.h"
#include "mesh/repair_parts.h"
#include "mesh/up_axis.h"
#include "mesh/validate.h"
#include "tetrahedralize/quality.h"

namespace s3::cli {
namespace {

using Json = nlohmann::ordered_json;

Json places_json(const std::vector<Vec3>& places) {
  Json json = Json::array();
  for (const Vec3& p : places) json.push_back({p.x(), p.y(), p.z()});
  return json;
}

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

void print_orientations(const Json& orientations) {
  std::printf("%-22s overhang mm2  support mm3  contact mm2  height mm  stable\n", "input.rotate");
  for (const Json& o : orientations) {
    const auto number = [&](const char* key) { return o[key].get<double>(); };
    std::printf("  %-20s %12.1f %12.1f %12.1f %10.2f  %s\n", o["rotate"].get<std::string>().c_str(),
                number("overhang_area_mm2"), number("support_volume_mm3"),
                number("contact_area_mm2"), number("height_mm"),
                o["stable"].get<bool>() ? "yes" : "no");
  }
}

void print_text(const Json& json) {
  for (const auto& [key, value] : json.items()) {
    if (key == "shells") {
      std::printf("%-22s %zu\n", key.c_str(), value.size());
    } else if (key == "orientations") {
      print_orientations(value);
    } else if (value.is_object() && value.contains("count")) {
      std::printf("%-22s %s", key.c_str(), value["count"].dump().c_str());
      if (!value["where"].empty()) std::printf("  first at %s", value["where"][0].dump().c_str());
      std::printf("\n");
    } else if (value.is_array() && (value.empty() || value[0].is_string())) {
      std::printf("%-22s %s\n", key.c_str(), value.empty() ? "none" : "");
      for (const auto& sentence : value) std::printf("  %s\n", sentence.get<std::string>().c_str());
    } else if (key == "repairs") {
      std::printf("%s\n", key.c_str());
      for (const auto& change : value) {
        std::printf("  %s", change["sentence"].get<std::string>().c_str());
        if (!change["where"].empty())
          std::printf(", first at %s", change["where"][0].dump().c_str());
        std::printf("\n");
      }
    } else {
      std::printf("%-22s %s\n", key.c_str(),
                  value.is_string() ? value.get<std::string>().c_str() : value.dump().c_str());
    }
  }
}

}  // namespace

int inspect_command(const std::string& model, bool as_json) {
  InterruptibleContext interruptible(1);
  Context& ctx = interruptible.context;
  ModelFile file = read_model(read_file(model), model);
  Json json = {{"file", model}, {"format", file.format}, {"is_volume", file.is_volume}};
  if (file.part_names.size() > 1) json["parts"] = file.part_names;
  for (Warning& warning : file.warnings) ctx.warnings.push_back(std::move(warning));
  json.update(file.is_volume ? inspect_volume_file(std::move(file), ctx)
                             : inspect_surface_file(file, ctx));
  Json warnings = Json::array();
  for (const Warning& warning : ctx.warnings) warnings.push_back(warning.message);
  json["warnings"] = warnings;
  if (as_json) {
    std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  } else {
    print_text(json);
  }
  return kDone;
}

}  // namespace s3::cli
