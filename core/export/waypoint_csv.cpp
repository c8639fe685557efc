#include "export/waypoint_csv.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <vector>

#include "base/error.h"
#include "export/number_text.h"

namespace s3 {
namespace {

constexpr std::string_view kColumns =
    "layer,path,kind,x,y,z,nx,ny,nz,tx,ty,tz,width,height,e,speed,travel";
constexpr std::size_t kColumnCount = 17;

[[noreturn]] void fail(std::size_t line, const std::string& what) {
  throw Error(ErrorKind::input, Stage::exporting, "export.bad_waypoint_csv",
              "Line " + std::to_string(line) + " of the waypoint file " + what + ".",
              "Use a waypoints.csv as this program writes it.");
}

/// A field as a number: a bounded copy for strtod, which needs an end mark.
double parse_number(std::string_view field, std::size_t line) {
  char copy[64];
  if (field.empty() || field.size() >= sizeof copy) fail(line, "has a field that is not a number");
  std::memcpy(copy, field.data(), field.size());
  copy[field.size()] = 0;
  char* end = nullptr;
  const double value = std::strtod(copy, &end);
  if (end != copy + field.size() || !std::isfinite(value))
    fail(line, "has \"" + std::string(field) + "\" where a number belongs");
  return value;
}

Index parse_index(std::string_view field, std::size_t line) {
  const double value = parse_number(field, line);
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<Index>::max())
    fail(line, "has \"" + std::string(field) + "\" where a whole number belongs");
  return static_cast<Index>(value);
}

PathKind parse_kind(std::string_view field, std::size_t line) {
  for (const PathKind kind : {PathKind::wall, PathKind::infill, PathKind::gap_fill})
    if (field == path_kind_name(kind)) return kind;
  fail(line, "has the unknown kind \"" + std::string(field.substr(0, 40)) + "\"");
}

std::array<std::string_view, kColumnCount> split(std::string_view line, std::size_t number) {
  std::array<std::string_view, kColumnCount> fields;
  for (std::size_t k = 0; k < kColumnCount; ++k) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != (k + 1 == kColumnCount))
      fail(number, "does not have 17 columns");
    fields[k] = line.substr(0, comma);
    if (comma != std::string_view::npos) line.remove_prefix(comma + 1);
  }
  return fields;
}

std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

}  // namespace

std::string write_waypoint_csv(const Waypoints& w) {
  std::string text;
  text.reserve(static_cast<std::size_t>(w.size()) * 140 + 1000);
  text +=
      "# S3 Slicer waypoints, in print order\n"
      "# units: x y z width height mm, e mm of filament since the waypoint before, speed mm/s at "
      "the tip\n"
      "# frame: the model's place on the plate, right-handed, z up, plate at z = 0; x y z is the "
      "nozzle's tip\n"
      "# n: unit normal of the layer, away from the material (the nozzle points against it); t: "
      "unit direction of travel\n"
      "# travel: 1 where the way to the waypoint is made without extruding; kind: wall, infill or "
      "gap_fill\n";
  text += kColumns;
  text += '\n';
  for (Index i = 0; i < w.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    append_integer(text, w.layer[k]);
    text += ',';
    append_integer(text, w.path[k]);
    text += ',';
    text += path_kind_name(w.kind[k]);
    const auto add = [&](double value, int decimals) {
      text += ',';
      append_fixed(text, value, decimals);
    };
    for (int c = 0; c < 3; ++c) add(w.position(i, c), 5);
    for (int c = 0; c < 3; ++c) add(w.normal(i, c), 6);
    for (int c = 0; c < 3; ++c) add(w.tangent(i, c), 6);
    add(w.width(i), 4);
    add(w.height(i), 4);
    add(w.extrusion(i), 6);
    add(w.speed(i), 3);
    text += w.travel[k] ? ",1\n" : ",0\n";
  }
  return text;
}

Waypoints read_waypoint_csv(std::string_view text) {
  struct Row {
    std::array<double, 13> number;
    Index layer, path;
    PathKind kind;
    bool travel;
  };
  std::vector<Row> rows;
  bool named = false;
  for (std::size_t line_number = 1; !text.empty(); ++line_number) {
    const std::string_view line = next_line(text);
    if (line.empty() || line.front() == '#') continue;
    if (!named) {
      if (line != kColumns) fail(line_number, "does not name the columns " + std::string(kColumns));
      named = true;
      continue;
    }
    const auto fields = split(line, line_number);
    Row row;
    row.layer = parse_index(fields[0], line_number);
    row.path = parse_index(fields[1], line_number);
    row.kind = parse_kind(fields[2], line_number);
    for (std::size_t k = 0; k < row.number.size(); ++k)
      row.number[k] = parse_number(fields[3 + k], line_number);
    if (fields[16] != "0" && fields[16] != "1")
      fail(line_number, "has a travel flag other than 0 and 1");
    row.travel = fields[16] == "1";
    rows.push_back(row);
  }
  if (!named) fail(1, "is missing: there is no line of column names");
  Waypoints w;
  const auto n = static_cast<Eigen::Index>(rows.size());
  w.position.resize(n, 3);
  w.normal.resize(n, 3);
  w.tangent.resize(n, 3);
  for (Values* v : {&w.width, &w.height, &w.extrusion, &w.speed}) v->resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    for (int c = 0; c < 3; ++c) {
      w.position(i, c) = row.number[static_cast<std::size_t>(c)];
      w.normal(i, c) = row.number[static_cast<std::size_t>(3 + c)];
      w.tangent(i, c) = row.number[static_cast<std::size_t>(6 + c)];
    }
    w.width(i) = row.number[9];
    w.height(i) = row.number[10];
    w.extrusion(i) = row.number[11];
    w.speed(i) = row.number[12];
    w.component.push_back(row.layer);
    w.layer.push_back(row.layer);
    w.path.push_back(row.path);
    w.kind.push_back(row.kind);
    w.travel.push_back(row.travel ? 1 : 0);
  }
  return w;
}

}  // namespace s3
