#include <cmath>

#include <nlohmann/json.hpp>

#include "base/units.h"
#include "mesh/orientation_json.h"
#include "metrics/metrics_json.h"
#include "pipeline/outputs.h"
#include "pipeline/places_json.h"
#include "tetrahedralize/quality.h"

namespace s3 {
namespace {

using Json = nlohmann::ordered_json;

Json input_json(const Pipeline& pipeline, const std::string& file) {
  const ModelInfo& model = pipeline.artifacts().model;
  Json sentences = Json::array(), details = Json::array();
  for (const RepairChange& change : model.repairs) {
    sentences.push_back(change.sentence);
    details.push_back(
        {{"code", change.code}, {"count", change.count}, {"where", places_json(change.places)}});
  }
  return {{"file", file},
          {"triangles", model.triangles},
          {"volume_mm3", model.volume ? Json(*model.volume) : Json(nullptr)},
          {"repairs", sentences},
          {"orientations", to_json(model.orientations)},
          {"repair_details", details},
          {"defect", model.defect.empty() ? Json(nullptr) : Json(model.defect)}};
}

Json distance_json(const DistanceFigures& d, double diagonal) {
  return {{"mean", d.mean},
          {"p95", d.p95},
          {"max", d.max},
          {"mean_percent", 100 * d.mean / diagonal},
          {"p95_percent", 100 * d.p95 / diagonal},
          {"max_percent", 100 * d.max / diagonal},
          {"where", {d.place.x(), d.place.y(), d.place.z()}}};
}

/// How far a rebuilt solid is from the triangles it was made of; null for one that keeps them.
Json rebuilt_json(const Filling& filling) {
  if (!filling.rebuilt) return nullptr;
  return {{"distance_mm",
           {{"to_input", distance_json(filling.distance.from_made, filling.diagonal)},
            {"from_input", distance_json(filling.distance.from_given, filling.diagonal)}}},
          {"diagonal_mm", filling.diagonal},
          {"inner_share", filling.distance.inner_share}};
}

Json mesh_json(const Pipeline& pipeline) {
  const TetMesh& rest = pipeline.artifacts().rest;
  const Filling& filling = pipeline.artifacts().filling;
  if (!pipeline.is_done(Stage::tetrahedralize))
    return {{"vertices", nullptr},
            {"tets", nullptr},
            {"boundary_faces", nullptr},
            {"min_dihedral_deg", nullptr}};
  return {{"vertices", rest.vertex_count()},
          {"tets", rest.tet_count()},
          {"boundary_faces", rest.boundary_faces.rows()},
          {"volume_mm3", enclosed_volume(boundary_surface(rest))},
          {"min_dihedral_deg", degrees(tet_quality(rest).min_dihedral)},
          {"backend", filling.backend},
          {"fallback", filling.fallback.empty() ? Json(nullptr) : Json(filling.fallback)},
          {"rebuilt", rebuilt_json(filling)}};
}

Json timings_json(const Pipeline& pipeline, const RunFigures& figures) {
  const auto of_stage = [&](Stage stage) -> Json {
    for (const StageRecord& record : pipeline.stages())
      if (record.stage == stage && record.state == StageState::done) return record.seconds;
    return nullptr;
  };
  const bool deformed = pipeline.is_done(Stage::outer_loop);
  const DeformTimings& t = pipeline.artifacts().deformation.timings;
  const auto of_deformation = [&](double seconds) -> Json {
    return deformed ? Json(seconds) : Json(nullptr);
  };
  Json json;
  json["repair"] = of_stage(Stage::mesh);
  json["tetrahedralize"] = of_stage(Stage::tetrahedralize);
  json["fea"] = of_stage(Stage::fea);
  json["objectives"] = of_stage(Stage::objectives);
  json["lpd_projection"] = of_deformation(t.lpd_projection);
  json["quaternion"] = of_deformation(t.quaternion);
  json["deformation"] = of_deformation(t.deformation);
  json["refinement"] = of_deformation(t.refinement);
  json["foldover"] = of_deformation(t.foldover);
  json["outer_loop"] = of_stage(Stage::outer_loop);
  json["layers"] = of_stage(Stage::layers);
  json["toolpaths"] = of_stage(Stage::toolpaths);
  json["waypoints"] = of_stage(Stage::waypoints);
  json["motion"] = of_stage(Stage::motion);
  json["metrics"] = of_stage(Stage::metrics);
  json["planar_baseline"] =
      pipeline.is_done(Stage::metrics) ? Json(pipeline.planar_seconds()) : Json(nullptr);
  json["export"] = figures.export_seconds;
  json["total"] = figures.total_seconds;
  return json;
}

/// CPU seconds of all threads by stage: what a busy machine does not change.
Json cpu_json(const Pipeline& pipeline) {
  Json json;
  for (const StageRecord& record : pipeline.stages())
    json[std::string(stage_name(record.stage))] =
        record.state == StageState::done && record.cpu_seconds ? Json(*record.cpu_seconds)
                                                               : Json(nullptr);
  return json;
}

Json warnings_json(const Pipeline& pipeline) {
  Json json = Json::array();
  for (const StageRecord& record : pipeline.stages())
    for (const Warning& warning : record.warnings) {
      json.push_back({{"code", warning.code},
                      {"message", warning.message},
                      {"where", places_json(warning.where)}});
    }
  return json;
}

}  // namespace

std::string report_json(const Pipeline& pipeline, const RunFigures& figures) {
  const Artifacts& a = pipeline.artifacts();
  const bool deformed = pipeline.is_done(Stage::outer_loop);
  const bool evaluated = pipeline.is_done(Stage::metrics);
  Json json;
  json["s3slice"] = S3_VERSION;
  json["input"] = input_json(pipeline, figures.model_file);
  json["mesh"] = mesh_json(pipeline);
  json["timings_s"] = timings_json(pipeline, figures);
  json["cpu_s"] = cpu_json(pipeline);
  json["threads"] = figures.threads;
  json["peak_memory_mb"] = figures.peak_memory_mb;
  json["outer_iterations"] = deformed ? Json(a.deformation.outer_iterations) : Json(nullptr);
  json["pi_rad"] = deformed ? Json(a.deformation.residual_history) : Json::array();
  json["curved"] = to_json(evaluated ? a.curved_metrics : Metrics{});
  json["planar"] = to_json(evaluated ? a.planar_metrics : Metrics{});
  json["warnings"] = warnings_json(pipeline);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace s3
