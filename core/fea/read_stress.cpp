#include "fea/read_stress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <Eigen/Eigenvalues>

#include "base/error.h"
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
    const PrincipalStress largest = largest_principal_stress(field.stress.row(t).transpose());
    field.principal_value[t] = largest.value;
    field.principal.row(t) = largest.direction.transpose();
  }
  return field;
}

StressField from_directions(const Table& table, std::string_view file_name) {
  const auto count = static_cast<Eigen::Index>(table.rows.size());
  StressField field;
  field.principal.resize(count, 3);
  field.principal_value.resize(count);
  for (Eigen::Index t = 0; t < count; ++t) {
    const Row& row = table.rows[static_cast<std::size_t>(t)];
    const Vec3 direction(row[1], row[2], row[3]);
    const double length = direction.stableNorm();
    // Where nothing pulls, there may be no direction, and none is needed.
    if (!(length > 0) && row[0] > 0)
      bad_file(file_name, table.line[static_cast<std::size_t>(t)], "tension without a direction");
    field.principal_value[t] = row[0];
    field.principal.row(t) = Vec3::UnitX().transpose();
    if (length > 0) field.principal.row(t) = direction.transpose() / length;
  }
  return field;
}

}  // namespace

StressField read_stress(std::span<const std::byte> bytes, std::string_view file_name,
                        Index tet_count, double critical_ratio) {
  const Table table = parse_table(as_text(bytes), file_name, tet_count);
  StressField field = table.columns == kTensorColumns ? from_tensors(table, file_name)
                                                      : from_directions(table, file_name);
  field.critical_tets = critical_tets(field.principal_value, critical_ratio);
  return field;
}

std::vector<Index> critical_tets(const Values& principal_value, double ratio) {
  std::vector<Index> tets;
  for (Eigen::Index t = 0; t < principal_value.size(); ++t)
    if (principal_value[t] > 0) tets.push_back(static_cast<Index>(t));
  const auto wanted = static_cast<std::size_t>(
      std::floor(std::clamp(ratio, 0.0, 1.0) * static_cast<double>(principal_value.size()) + 1e-9));
  if (wanted < tets.size()) {
    const auto border = tets.begin() + static_cast<std::ptrdiff_t>(wanted);
    std::nth_element(tets.begin(), border, tets.end(), [&](Index a, Index b) {
      return principal_value[a] != principal_value[b] ? principal_value[a] > principal_value[b]
                                                      : a < b;
    });
    tets.erase(border, tets.end());
    std::sort(tets.begin(), tets.end());
  }
  return tets;
}

void rotate_stress(StressField& field, const Mat3& rotation) {
  field.principal = (field.principal * rotation.transpose()).eval();
  for (Eigen::Index t = 0; t < field.stress.rows(); ++t) {
    const auto s = field.stress.row(t);
    Mat3 tensor;
    tensor << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
    const Mat3 turned = rotation * tensor * rotation.transpose();
    field.stress.row(t) << turned(0, 0), turned(1, 1), turned(2, 2), turned(1, 2), turned(0, 2),
        turned(0, 1);
  }
}

PrincipalStress largest_principal_stress(const Eigen::Matrix<double, 6, 1>& s) {
  Mat3 tensor;
  tensor << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(tensor);
  PrincipalStress result{eigen.eigenvalues()[2], eigen.eigenvectors().col(2)};
  Eigen::Index largest = 0;
  result.direction.cwiseAbs().maxCoeff(&largest);
  if (result.direction[largest] < 0) result.direction = -result.direction;
  return result;
}

}  // namespace s3
