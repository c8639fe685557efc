#include "fea/read_stress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "mesh/read_vtu.h"
#include "mesh/text_scanner.h"

namespace s3 {
namespace {

constexpr std::size_t kTensorColumns = 8;     // index,maxPrincipal,S11,S22,S33,S12,S13,S23
constexpr std::size_t kDirectionColumns = 5;  // principal x y z line-id
constexpr std::string_view kSeparators = ", ;\t\r";

using Row = std::array<double, kTensorColumns>;

[[noreturn]] void bad_file(std::string_view file_name, std::int64_t line, const std::string& what) {
  throw Error(
      ErrorKind::input, Stage::fea, "fea.bad_stress_file",
      std::string(file_name) + ": line " + std::to_string(line) + ": " + what + ".",
      "Expected are rows of eight columns (index,maxPrincipal,S11,S22,S33,S12,S13,S23) or five "
      "(principal x y z line-id).");
}

[[noreturn]] void wrong_count(std::string_view file_name, std::int64_t line, std::int64_t rows,
                              Index tet_count) {
  throw Error(ErrorKind::input, Stage::fea, "fea.stress_count",
              std::string(file_name) + " has stress for " + std::to_string(rows) +
                  " tets, but the mesh has " + std::to_string(tet_count) + " (" +
                  (rows > tet_count ? "the first row too many is" : "the last row is") + " line " +
                  std::to_string(line) + ").",
              "Use the stress file that belongs to this tet mesh.");
}

std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

std::string_view take_field(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kSeparators), line.size()));
  const std::size_t end = std::min(line.find_first_of(kSeparators), line.size());
  const std::string_view field = line.substr(0, end);
  line.remove_prefix(end);
  return field;
}

/// The table of numbers in a file, with the line of every row.
struct Table {
  std::size_t columns = 0;
  std::vector<Row> rows;
  std::vector<std::int64_t> line;
};

/// @return false when a field is not a number; throws for any other fault of the line
bool parse_row(std::string_view line, std::string_view file_name, std::int64_t number,
               Table& table) {
  Row row = {};
  std::size_t columns = 0;
  for (std::string_view field = take_field(line); !field.empty(); field = take_field(line)) {
    if (columns == kTensorColumns) bad_file(file_name, number, "more than eight columns");
    const std::optional<double> value = parse_double(field);
    if (!value) {
      if (table.rows.empty()) return false;
      bad_file(file_name, number, "'" + std::string(field.substr(0, 40)) + "' is not a number");
    }
    row[columns++] = *value;
  }
  if (table.columns == 0) table.columns = columns;
  if (columns != table.columns || (columns != kTensorColumns && columns != kDirectionColumns))
    bad_file(file_name, number, std::to_string(columns) + " columns");
  table.rows.push_back(row);
  table.line.push_back(number);
  return true;
}

/// Keeps tet_count rows and counts the rest, so that a file of any size costs no more memory than
/// the mesh.
Table parse_table(std::string_view text, std::string_view file_name, Index tet_count) {
  Table table;
  bool header_seen = false;
  std::int64_t number = 0, rows = 0, first_extra = 0;
  while (!text.empty()) {
    const std::string_view line = take_line(text);
    ++number;
    if (line.find_first_not_of(kSeparators) == std::string_view::npos || line.front() == '#')
      continue;
    if (rows == tet_count && first_extra == 0) first_extra = number;
    if (first_extra == 0 && !parse_row(line, file_name, number, table)) {
      if (header_seen) bad_file(file_name, number, "a second line that is no row of numbers");
      header_seen = true;
      continue;
    }
    ++rows;
  }
  if (rows != tet_count)
    wrong_count(file_name,
                first_extra > 0      ? first_extra
                : table.line.empty() ? number
                                     : table.line.back(),
                rows, tet_count);
  return table;
}

/// τ_max and its value from the tensor that is there.
void set_tensor_stress(StressField& field, Eigen::Index t) {
  const PrincipalStresses p = principal_stresses(field.stress.row(t).transpose());
  field.principal_value[t] = p.value[2];
  field.principal.row(t) = p.direction.col(2).transpose();
}

StressField from_tensors(const Table& table, std::string_view file_name) {
  const auto count = static_cast<Eigen::Index>(table.rows.size());
  StressField field;
  field.stress.resize(count, 6);
  field.principal.resize(count, 3);
  field.principal_value.resize(count);
  std::vector<char> seen(table.rows.size(), 0);
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    const Row& row = table.rows[r];
    if (row[0] != std::floor(row[0]) || row[0] < 1 || row[0] > static_cast<double>(count))
      bad_file(file_name, table.line[r],
               "the tet index is not a whole number from 1 to " + std::to_string(count));
    const auto t = static_cast<Eigen::Index>(row[0]) - 1;
    if (seen[static_cast<std::size_t>(t)] != 0)
      bad_file(file_name, table.line[r], "tet " + std::to_string(t + 1) + " for the second time");
    seen[static_cast<std::size_t>(t)] = 1;
    // The file has 11 22 33 12 13 23, the field xx yy zz yz zx xy.
    field.stress.row(t) << row[2], row[3], row[4], row[7], row[6], row[5];
    set_tensor_stress(field, t);
  }
  return field;
}

/// Stores one tet's principal stress. Where nothing pulls, there may be no direction, and none is
/// needed.
/// @return false for tension without a direction
bool set_direction(StressField& field, Eigen::Index t, double value, const Vec3& direction) {
  const double length = direction.stableNorm();
  field.principal_value[t] = value;
  field.principal.row(t) = Vec3::UnitX().transpose();
  if (length > 0) field.principal.row(t) = direction.transpose() / length;
  return length > 0 || value <= 0;
}

StressField from_directions(const Table& table, std::string_view file_name) {
  const auto count = static_cast<Eigen::Index>(table.rows.size());
  StressField field;
  field.principal.resize(count, 3);
  field.principal_value.resize(count);
  for (Eigen::Index t = 0; t < count; ++t) {
    const Row& row = table.rows[static_cast<std::size_t>(t)];
    if (!set_direction(field, t, row[0], Vec3(row[1], row[2], row[3])))
      bad_file(file_name, table.line[static_cast<std::size_t>(t)], "tension without a direction");
  }
  return field;
}

StressField from_text(std::span<const std::byte> bytes, std::string_view file_name,
                      Index tet_count) {
  const Table table = parse_table(as_text(bytes), file_name, tet_count);
  return table.columns == kTensorColumns ? from_tensors(table, file_name)
                                         : from_directions(table, file_name);
}

[[noreturn]] void bad_vtu(std::string_view file_name, const std::string& what) {
  throw Error(
      ErrorKind::input, Stage::fea, "fea.bad_stress_file",
      std::string(file_name) + ": " + what + ".",
      "Expected is cell data `stress` with 6 or 9 components, or `tau_max` with 3 and `sigma_max` "
      "with 1.");
}

const VtuArray* find_array(const VtuFile& file, const std::string& name) {
  const auto found = file.cell_data.find(name);
  return found == file.cell_data.end() ? nullptr : &found->second;
}

void check_finite(const VtuArray& array, std::string_view file_name, const std::string& name) {
  for (std::size_t i = 0; i < array.values.size(); ++i)
    if (!std::isfinite(array.values[i]))
      bad_vtu(file_name, "`" + name + "` is not a number in tet " +
                             std::to_string(i / static_cast<std::size_t>(array.components)));
}

StressField from_vtu_tensors(const VtuArray& array, Eigen::Index count) {
  StressField field;
  field.stress.resize(count, 6);
  field.principal.resize(count, 3);
  field.principal_value.resize(count);
  for (Eigen::Index t = 0; t < count; ++t) {
    const double* s = array.values.data() + t * array.components;
    if (array.components == 6)
      field.stress.row(t) << s[0], s[1], s[2], s[4], s[5], s[3];
    else
      field.stress.row(t) << s[0], s[4], s[8], 0.5 * (s[5] + s[7]), 0.5 * (s[2] + s[6]),
          0.5 * (s[1] + s[3]);
    set_tensor_stress(field, t);
  }
  return field;
}

StressField from_vtu(std::span<const std::byte> bytes, std::string_view file_name,
                     Index tet_count) {
  const VtuFile file = read_vtu(bytes, file_name);
  if (file.tets.rows() != tet_count)
    throw Error(ErrorKind::input, Stage::fea, "fea.stress_count",
                std::string(file_name) + " has " + std::to_string(file.tets.rows()) +
                    " tets, but the mesh has " + std::to_string(tet_count) + ".",
                "Use the stress file that belongs to this tet mesh.");
  if (const VtuArray* stress = find_array(file, "stress")) {
    if (stress->components != 6 && stress->components != 9)
      bad_vtu(file_name, "`stress` has " + std::to_string(stress->components) + " components");
    check_finite(*stress, file_name, "stress");
    return from_vtu_tensors(*stress, tet_count);
  }
  const VtuArray* direction = find_array(file, "tau_max");
  const VtuArray* value = find_array(file, "sigma_max");
  if (direction == nullptr || value == nullptr || direction->components != 3 ||
      value->components != 1)
    bad_vtu(file_name, "no stress in the cell data");
  check_finite(*direction, file_name, "tau_max");
  check_finite(*value, file_name, "sigma_max");
  StressField field;
  field.principal.resize(tet_count, 3);
  field.principal_value.resize(tet_count);
  for (Index t = 0; t < tet_count; ++t) {
    const double* d = direction->values.data() + 3 * static_cast<std::ptrdiff_t>(t);
    if (!set_direction(field, t, value->values[t], Vec3(d[0], d[1], d[2])))
      bad_vtu(file_name, "tension without a direction in tet " + std::to_string(t));
  }
  return field;
}

bool looks_like_xml(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '<';
}

}  // namespace

StressField read_stress(std::span<const std::byte> bytes, std::string_view file_name,
                        Index tet_count, double critical_ratio) {
  StressField field = looks_like_xml(as_text(bytes)) ? from_vtu(bytes, file_name, tet_count)
                                                     : from_text(bytes, file_name, tet_count);
  field.critical_tets = critical_tets(field.principal_value, critical_ratio);
  return field;
}

}  // namespace s3
