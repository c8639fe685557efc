#include "pipeline/outputs.h"

#include <cmath>
#include <cstdio>

#include "export/fields_vtu.h"
#include "export/layers_ply.h"
#include "export/stress_csv.h"
#include "export/waypoint_csv.h"
#include "params/param_visitors.h"

namespace s3 {
namespace {

std::string number(const std::optional<double>& value, int digits) {
  if (!value) return "-";
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", digits, *value);
  return text;
}

std::string number(const std::optional<int>& value) {
  return value ? std::to_string(*value) : "-";
}

std::string thickness(const Metrics& m) {
  if (!m.thickness_mm) return "-";
  return number(m.thickness_mm->min, 2) + " to " + number(m.thickness_mm->max, 2);
}

std::string print_time(const Metrics& m) {
  if (!m.print_time_s) return "-";
  const long minutes = std::lround(*m.print_time_s / 60);
  char text[48];
  std::snprintf(text, sizeof text, "%ld h %02ld min", minutes / 60, minutes % 60);
  return text;
}

void add_row(std::string& table, const char* name, const std::string& curved,
             const std::string& planar) {
  char row[160];
  std::snprintf(row, sizeof row, "%-38s %16s %16s\n", name, curved.c_str(), planar.c_str());
  table += row;
}

/// Rows and axes as the model file has them, so that the stress can be imported with it; for a
/// surface, which has no tets, those of fields.vtu.
std::string stress_in_file_frame(const Artifacts& a) {
  if (!a.model.is_volume) return write_stress_csv(*a.stress, {});
  StressField stress = *a.stress;
  rotate_stress(stress, a.placement.rotation().transpose());
  return write_stress_csv(stress, a.file_order.tets);
}

}  // namespace

std::vector<OutputFile> stage_files(const Pipeline& pipeline, Stage stage) {
  std::vector<OutputFile> files;
  if (!pipeline.is_done(stage)) return files;
  const Artifacts& a = pipeline.artifacts();
  const auto add = [&](std::string name, std::function<std::string()> content) {
    files.push_back({std::move(name), stage, std::move(content)});
  };
  if (stage == Stage::fea && a.load_cases && a.stress)
    add("stress.csv", [&a] { return stress_in_file_frame(a); });
  if (stage == Stage::outer_loop)
    add("fields.vtu", [&a] {
      return write_fields_vtu(a.rest, a.deformation, a.stress ? &*a.stress : nullptr, a.file_order);
    });
  if (stage == Stage::layers)
    for (std::size_t i = 0; i < a.curved.layers.layers.size(); ++i)
      add(layer_file_name(i), [&a, i] { return write_layer_ply(a.curved.layers.layers[i]); });
  if (stage == Stage::waypoints)
    add("waypoints.csv", [&a] { return write_waypoint_csv(a.curved.waypoints); });
  if (stage == Stage::exporting)
    for (const NamedFile& file : a.programs) add(file.name, [&file] { return file.content; });
  if (stage == Stage::metrics)
    for (const SvgFile& file : a.plots) add(file.name, [&file] { return file.text; });
  return files;
}

std::string job_json(const Pipeline& pipeline) {
  Params params = pipeline.params();
  return to_json(list_params(params));
}

std::string summary_table(const Pipeline& pipeline) {
  const Metrics& c = pipeline.artifacts().curved_metrics;
  const Metrics& p = pipeline.artifacts().planar_metrics;
  std::string table;
  add_row(table, "", "curved", "planar");
  const auto row = [&](const char* name, const auto& text) {
    add_row(table, name, text(c), text(p));
  };
  row("support free, % of the surface",
      [](const Metrics& m) { return number(m.support_free_area_percent, 2); });
  row("surface quality, % of the surface",
      [](const Metrics& m) { return number(m.surface_quality_area_percent, 2); });
  if (c.surface_quality_region_percent)
    row("surface quality, % of its region",
        [](const Metrics& m) { return number(m.surface_quality_region_percent, 2); });
  row("strength, % of the critical tets",
      [](const Metrics& m) { return number(m.strength_critical_percent, 2); });
  row("foldovers", [](const Metrics& m) { return number(m.foldovers); });
  row("islands", [](const Metrics& m) { return number(m.islands); });
  row("layers", [](const Metrics& m) { return number(m.layers); });
  row("layer pieces", [](const Metrics& m) { return number(m.components); });
  row("layer thickness, mm", thickness);
  row("coverage, % of the layers", [](const Metrics& m) { return number(m.coverage_percent, 2); });
  row("surface error, mean mm", [](const Metrics& m) { return number(m.surface_error_avg_mm, 3); });
  row("strain, 99.9 % of the volume below, %", [](const Metrics& m) {
    return number(m.strain ? std::optional<double>(100 * m.strain->p999) : std::nullopt, 4);
  });
  row("strain, mean %", [](const Metrics& m) {
    return number(m.strain ? std::optional<double>(100 * m.strain->mean) : std::nullopt, 4);
  });
  row("support volume, mm3", [](const Metrics& m) { return number(m.support_volume_mm3, 0); });
  row("material, g", [](const Metrics& m) { return number(m.material_g, 1); });
  row("print time", print_time);
  return table;
}

}  // namespace s3
