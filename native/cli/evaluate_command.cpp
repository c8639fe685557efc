// The figures of a run once more, from its files alone: fields.vtu, layers/*.ply, waypoints.csv and
// job.json.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "commands.h"
#include "export/layers_ply.h"
#include "export/waypoint_csv.h"
#include "files.h"
#include "mesh/read_vtu.h"
#include "metrics/metrics_json.h"
#include "metrics/print_metrics.h"
#include "metrics/printed_coverage.h"
#include "metrics/strain.h"
#include "metrics/thickness.h"
#include "params/param_visitors.h"
#include "pipeline/evaluate.h"

namespace fs = std::filesystem;

namespace s3::cli {
namespace {

const VtuArray& array_of(const std::map<std::string, VtuArray>& arrays, const char* name,
                         int components, Eigen::Index rows) {
  const auto found = arrays.find(name);
  if (found == arrays.end() || found->second.components != components ||
      found->second.values.size() != static_cast<std::size_t>(rows * components))
    throw Error(ErrorKind::input, Stage::exporting, "export.bad_file",
                std::string("fields.vtu has no array ") + name + " of the right shape",
                "run s3slice again");
  return found->second;
}

Points rows_of_three(const VtuArray& array) {
  return Eigen::Map<const Points>(array.values.data(),
                                  static_cast<Eigen::Index>(array.values.size() / 3), 3);
}

std::optional<StressField> stress_of(const VtuFile& file) {
  if (!file.cell_data.contains("critical")) return std::nullopt;
  const Eigen::Index tets = file.tets.rows();
  StressField stress;
  stress.principal = rows_of_three(array_of(file.cell_data, "tau_max", 3, tets));
  const VtuArray& value = array_of(file.cell_data, "sigma_max", 1, tets);
  stress.principal_value = Eigen::Map<const Values>(value.values.data(), tets);
  const VtuArray& critical = array_of(file.cell_data, "critical", 1, tets);
  for (Index t = 0; t < tets; ++t)
    if (critical.values[static_cast<std::size_t>(t)] != 0) stress.critical_tets.push_back(t);
  return stress;
}

LayerStack read_layers(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".ply") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  LayerStack stack;
  for (const fs::path& file : files) {
    stack.layers.push_back(read_layer_ply(read_file(file), file.string()));
    stack.isosurfaces = std::max(stack.isosurfaces, stack.layers.back().layer + 1);
  }
  return stack;
}

Waypoints read_waypoints(const fs::path& file) {
  if (!fs::exists(file)) return {};
  const auto bytes = read_file(file);
  return read_waypoint_csv({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Params read_params(const fs::path& file) {
  Params params;
  const auto bytes = read_file(file);
  from_json(list_params(params), {reinterpret_cast<const char*>(bytes.data()), bytes.size()},
            file.string());
  return params;
}

double printed_length(const Waypoints& waypoints) {
  double length = 0;
  for (Index i = 1; i < waypoints.size(); ++i)
    if (!waypoints.travel[static_cast<std::size_t>(i)])
      length += (waypoints.position.row(i) - waypoints.position.row(i - 1)).norm();
  return length;
}

void print_figures(const fs::path& folder, const Artifacts& artifacts, const Params& params,
                   const MachineProfile& machine, Metrics& metrics, Context& ctx) {
  const LayerStack layers = read_layers(folder / "layers");
  if (layers.layers.empty()) return;
  layer_metrics(layers, params.layers.min_thickness, params.layers.max_thickness, metrics, ctx);
  const Waypoints waypoints = read_waypoints(folder / "waypoints.csv");
  if (waypoints.size() == 0) return;
  metrics.path_length_mm = printed_length(waypoints);
  metrics.coverage_percent =
      printed_coverage_percent(layers, waypoints, params.toolpath.width, ctx);
  waypoint_metrics(waypoints, machine, metrics);
  surface_error(artifacts.surface, waypoints, metrics, ctx);
  if (params.strength.load_case.empty()) return;
  const auto load_cases =
      read_load_cases(read_file(params.strength.load_case), params.strength.load_case);
  metrics.strain = strain_figures(printed_strain(artifacts.rest, waypoints, load_cases, ctx),
                                  tet_volumes(artifacts.rest));
}

}  // namespace

int evaluate_command(const std::string& folder_name) {
  InterruptibleContext interruptible(thread_count(0));
  Context& ctx = interruptible.context;
  const fs::path folder = folder_name;
  const Params job = read_params(folder / "job.json");
  const MachineProfile machine = load_machine(job.machine.machine);
  const Params params = resolve(job, machine);

  const VtuFile file = read_vtu(read_file(folder / "fields.vtu"), (folder / "fields.vtu").string());
  Artifacts artifacts;
  artifacts.rest = make_tet_mesh(file.vertices, file.tets);
  artifacts.surface = boundary_surface(artifacts.rest);
  artifacts.stress = stress_of(file);
  std::optional<Region> region;
  if (const std::string& name = params.objectives.surface_region; !name.empty())
    region = read_region_file(read_file(name), name, Stage::objectives);
  artifacts.objectives =
      make_objectives(artifacts.rest, params.objectives,
                      artifacts.stress ? &*artifacts.stress : nullptr, region ? &*region : nullptr);
  const VtuArray& g = array_of(file.point_data, "G", 1, file.vertices.rows());
  const Points deformed =
      rows_of_three(array_of(file.point_data, "deformed", 3, file.vertices.rows()));
  // The print directions follow from G: the array in the file is not asked.
  const ScalarField field = make_scalar_field(
      artifacts.rest, Eigen::Map<const Values>(g.values.data(), file.vertices.rows()));
  const ScalarField height = make_scalar_field(artifacts.rest, artifacts.rest.vertices.col(2));

  Evaluation curved = evaluate_field(artifacts, field, deformed, params, machine, ctx);
  print_figures(folder, artifacts, params, machine, curved.metrics, ctx);
  const Evaluation planar =
      evaluate_field(artifacts, height, artifacts.rest.vertices, params, machine, ctx);
  nlohmann::ordered_json json;
  json["curved"] = to_json(curved.metrics);
  json["planar"] = to_json(planar.metrics);
  std::printf("%s\n", json.dump(2).c_str());
  return kDone;
}

}  // namespace s3::cli
