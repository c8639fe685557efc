#include "sweep_table.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <optional>

#include <nlohmann/json.hpp>

#include "base/units.h"
#include "metrics/ternary_plot.h"
#include "params/param_visitors.h"

namespace s3::cli {
namespace {

using Json = nlohmann::ordered_json;

/// One figure of the table, and how the plot and the terminal show it.
struct Column {
  const char* key;      // of CSV and JSON: that of report.json where there is one
  const char* heading;  // on the terminal; null for none
  const char* title;    // of its triangle; null for none
  int digits;
  bool less_is_better;
  double unit;  // factor for plot and terminal
  std::optional<double> (*value)(const Metrics&);
};

std::optional<double> number(const std::optional<int>& value) {
  return value ? std::optional<double>(*value) : std::nullopt;
}

std::optional<double> strain_of(const Metrics& m, double StrainFigures::*figure) {
  return m.strain ? std::optional<double>((*m.strain).*figure) : std::nullopt;
}

const std::vector<Column>& columns() {
  constexpr double kPercent = 100;
  static const std::vector<Column> kColumns = {
      {"pi_rad", "Π °", "Π, distance to what is asked (°)", 2, true, degrees(1),
       [](const Metrics& m) { return m.pi_rad; }},
      {"support_free_area_percent", "SF %", "SF, surface without support (%)", 2, false, 1,
       [](const Metrics& m) { return m.support_free_area_percent; }},
      {"strength_critical_percent", "SR %", "SR, critical tets along tension (%)", 1, false, 1,
       [](const Metrics& m) { return m.strength_critical_percent; }},
      {"surface_quality_area_percent", "SQ %", "SQ, surface flat or upright (%)", 1, false, 1,
       [](const Metrics& m) { return m.surface_quality_area_percent; }},
      {"foldovers", "foldovers", nullptr, 0, true, 1,
       [](const Metrics& m) { return number(m.foldovers); }},
      {"islands", "islands", nullptr, 0, true, 1,
       [](const Metrics& m) { return number(m.islands); }},
      {"gouging_pairs", nullptr, nullptr, 0, true, 1,
       [](const Metrics& m) { return number(m.gouging_pairs); }},
      {"concave_pairs_over_20deg", nullptr, nullptr, 0, true, 1,
       [](const Metrics& m) { return number(m.concave_pairs_over_20deg); }},
      {"strain_max", "strain max %", nullptr, 4, true, kPercent,
       [](const Metrics& m) { return strain_of(m, &StrainFigures::max); }},
      {"strain_p999", "strain 99.9 %", "strain, 99.9 % of the volume below (%)", 3, true, kPercent,
       [](const Metrics& m) { return strain_of(m, &StrainFigures::p999); }},
      {"strain_mean", "strain mean %", "strain, mean (%)", 4, true, kPercent,
       [](const Metrics& m) { return strain_of(m, &StrainFigures::mean); }},
  };
  return kColumns;
}

/// Shortest text that reads back as the same number.
std::string exact(double value) {
  return Json(value).dump();
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string shown(const std::optional<double>& value, const Column& column) {
  if (!value) return "-";
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", column.digits, *value * column.unit);
  return text;
}

Json json_of(const WeightTriple& w) {
  return {{"support_free", w.support_free},
          {"strength", w.strength},
          {"surface_quality", w.surface_quality}};
}

Json figures_json(const Metrics& metrics) {
  Json json;
  for (const Column& column : columns()) {
    const auto value = column.value(metrics);
    json[column.key] = value ? Json(*value) : Json(nullptr);
  }
  return json;
}

Json warnings_json(const std::vector<Warning>& warnings) {
  Json json = Json::array();
  for (const Warning& warning : warnings)
    json.push_back({{"code", warning.code}, {"message", warning.message}});
  return json;
}

Json error_json(const std::string& error) {
  return error.empty() ? Json(nullptr) : Json(error);
}

bool has_figure(const SweepTable& table, const Column& column) {
  return std::any_of(table.rows.begin(), table.rows.end(),
                     [&](const SweepRow& row) { return column.value(row.metrics).has_value(); });
}

/// A name followed by spaces up to the width; Greek and degree signs are one column wide.
std::string padded(const std::string& text, std::size_t width) {
  const auto letters =
      static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](const char c) {
        return (static_cast<unsigned char>(c) & 0xc0) != 0x80;  // not inside a UTF-8 sequence
      }));
  return (letters < width ? std::string(width - letters, ' ') : "") + text;
}

}  // namespace

std::string name_of(const WeightTriple& w) {
  char text[96];
  std::snprintf(text, sizeof text, "SF %.4g SR %.4g SQ %.4g", w.support_free, w.strength,
                w.surface_quality);
  return text;
}

std::string sweep_csv(const SweepTable& table) {
  std::string csv = "layers,support_free,strength,surface_quality";
  for (const Column& column : columns()) csv += std::string(",") + column.key;
  csv += ",cpu_s,error\n";
  const auto add_figures = [&](const Metrics& metrics) {
    for (const Column& column : columns()) {
      const auto value = column.value(metrics);
      csv += ',';
      if (value) csv += exact(*value);
    }
  };
  csv += "planar,,,";
  add_figures(table.planar);
  const auto add_end = [&](double seconds, const std::string& error) {
    csv += "," + exact(seconds) + "," + (error.empty() ? "" : quoted(error)) + "\n";
  };
  add_end(table.planar_cpu_seconds, table.planar_error);
  for (const SweepRow& row : table.rows) {
    csv += "curved," + exact(row.weights.support_free) + "," + exact(row.weights.strength) + "," +
           exact(row.weights.surface_quality);
    add_figures(row.metrics);
    add_end(row.cpu_seconds, row.error);
  }
  return csv;
}

std::string sweep_json(const SweepTable& table, const Pipeline& pipeline) {
  const TetMesh& rest = pipeline.artifacts().rest;
  Params params = pipeline.params();
  Json json;
  json["s3slice"] = S3_VERSION;
  json["input"] = {{"file", table.model_file}};
  json["mesh"] = {{"vertices", rest.vertex_count()}, {"tets", rest.tet_count()}};
  json["asked"] = table.asked;
  json["ended"] = table.rows.size();
  json["shared_cpu_s"] = table.shared_cpu_seconds;
  json["planar"] = figures_json(table.planar);
  json["planar"]["cpu_s"] = table.planar_cpu_seconds;
  json["planar"]["error"] = error_json(table.planar_error);
  json["triples"] = Json::array();
  for (const SweepRow& row : table.rows) {
    Json entry = {{"weights", json_of(row.weights)}};
    entry.update(figures_json(row.metrics));
    entry["cpu_s"] = row.cpu_seconds;
    entry["error"] = error_json(row.error);
    entry["warnings"] = warnings_json(row.warnings);
    json["triples"].push_back(std::move(entry));
  }
  json["job"] = Json::parse(to_json(list_params(params)));
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string sweep_svg(const SweepTable& table) {
  TernaryPlot plot;
  plot.title = "Weights of the objectives and what they lead to (yellow is better)";
  plot.corners = {"support free", "strength", "surface quality"};
  for (const SweepRow& row : table.rows)
    plot.weights.emplace_back(row.weights.support_free, row.weights.strength,
                              row.weights.surface_quality);
  for (const Column& column : columns()) {
    if (column.title == nullptr || !has_figure(table, column)) continue;
    const auto scaled = [&](const Metrics& metrics) {
      auto value = column.value(metrics);
      if (value) *value *= column.unit;
      return value;
    };
    TernaryFigure figure{
        column.title, {}, scaled(table.planar), column.less_is_better, column.digits};
    for (const SweepRow& row : table.rows) figure.values.push_back(scaled(row.metrics));
    plot.figures.push_back(std::move(figure));
  }
  return ternary_svg(plot);
}

std::string sweep_text(const SweepTable& table) {
  constexpr std::size_t kName = 28, kColumn = 14;
  std::string text(kName, ' ');
  std::vector<Column> shown_columns;
  for (const Column& column : columns())
    if (column.heading != nullptr && has_figure(table, column)) shown_columns.push_back(column);
  for (const Column& column : shown_columns) text += padded(column.heading, kColumn);
  text += padded("CPU s", kColumn) + "\n";
  const auto add_row = [&](std::string name, const Metrics& metrics, double seconds,
                           const std::string& error) {
    name.resize(std::max(kName, name.size()), ' ');
    text += name;
    for (const Column& column : shown_columns)
      text += padded(shown(column.value(metrics), column), kColumn);
    char cpu[32];
    std::snprintf(cpu, sizeof cpu, "%.1f", seconds);
    text += padded(cpu, kColumn) + (error.empty() ? "" : "  failed: " + error) + "\n";
  };
  add_row("planar layers", table.planar, table.planar_cpu_seconds, table.planar_error);
  for (const SweepRow& row : table.rows)
    add_row(name_of(row.weights), row.metrics, row.cpu_seconds, row.error);
  return text;
}

}  // namespace s3::cli
