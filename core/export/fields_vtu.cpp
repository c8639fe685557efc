#include "export/fields_vtu.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

namespace s3 {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little endian");

void append_base64(std::string& out, std::span<const unsigned char> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  out.reserve(out.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const unsigned group = static_cast<unsigned>(bytes[i]) << 16 |
                           (left > 1 ? static_cast<unsigned>(bytes[i + 1]) << 8 : 0u) |
                           (left > 2 ? static_cast<unsigned>(bytes[i + 2]) : 0u);
    out += kDigits[group >> 18];
    out += kDigits[group >> 12 & 63];
    out += left > 1 ? kDigits[group >> 6 & 63] : '=';
    out += left > 2 ? kDigits[group & 63] : '=';
  }
}

template <class T>
const char* type_name();
template <>
const char* type_name<double>() {
  return "Float64";
}
template <>
const char* type_name<std::int32_t>() {
  return "Int32";
}
template <>
const char* type_name<std::uint8_t>() {
  return "UInt8";
}

template <class T>
void append_array(std::string& xml, const char* name, int components,
                  const std::vector<T>& values) {
  xml += "        <DataArray type=\"";
  xml += type_name<T>();
  xml += "\" Name=\"";
  xml += name;
  xml += "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"binary\">\n";
  // VTK encodes the byte count and the bytes as one block.
  const std::uint64_t size = values.size() * sizeof(T);
  std::vector<unsigned char> block(sizeof(size) + size);
  std::memcpy(block.data(), &size, sizeof(size));
  if (size > 0) std::memcpy(block.data() + sizeof(size), values.data(), size);
  append_base64(xml, block);
  xml += "\n        </DataArray>\n";
}

/// Rows of a matrix or vector in the order of the file.
template <class T, class Matrix>
std::vector<T> rows_in_order(const Matrix& matrix, const std::vector<Index>& order) {
  std::vector<T> values;
  values.reserve(static_cast<std::size_t>(matrix.size()));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    const Eigen::Index row = order.empty() ? i : order[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < matrix.cols(); ++k)
      values.push_back(static_cast<T>(matrix(row, k)));
  }
  return values;
}

std::vector<Index> tets_in_order(const TetMesh& rest, const FileOrder& order) {
  std::vector<Index> corners = rows_in_order<Index>(rest.tets, order.tets);
  if (order.vertices.empty()) return corners;
  std::vector<Index> file_vertex(order.vertices.size());
  for (std::size_t i = 0; i < order.vertices.size(); ++i)
    file_vertex[static_cast<std::size_t>(order.vertices[i])] = static_cast<Index>(i);
  for (Index& corner : corners) corner = file_vertex[static_cast<std::size_t>(corner)];
  return corners;
}

void append_cells(std::string& xml, const TetMesh& rest, const FileOrder& order) {
  const auto count = static_cast<std::size_t>(rest.tet_count());
  std::vector<Index> offsets(count);
  for (std::size_t t = 0; t < count; ++t) offsets[t] = static_cast<Index>(4 * (t + 1));
  constexpr std::uint8_t kVtkTetra = 10;
  xml += "      <Cells>\n";
  append_array(xml, "connectivity", 1, tets_in_order(rest, order));
  append_array(xml, "offsets", 1, offsets);
  append_array(xml, "types", 1, std::vector<std::uint8_t>(count, kVtkTetra));
  xml += "      </Cells>\n";
}

void append_stress(std::string& xml, const TetMesh& rest, const StressField& stress,
                   const std::vector<Index>& order) {
  Eigen::VectorXi critical = Eigen::VectorXi::Zero(rest.tet_count());
  for (const Index t : stress.critical_tets) critical(t) = 1;
  append_array(xml, "tau_max", 3, rows_in_order<double>(stress.principal, order));
  append_array(xml, "sigma_max", 1, rows_in_order<double>(stress.principal_value, order));
  append_array(xml, "critical", 1, rows_in_order<std::uint8_t>(critical, order));
  if (stress.stress.rows() == 0) return;
  Tensors vtk_order(stress.stress.rows(), 6);
  constexpr int kColumns[6] = {0, 1, 2, 5, 3, 4};
  for (int c = 0; c < 6; ++c) vtk_order.col(c) = stress.stress.col(kColumns[c]);
  append_array(xml, "stress", 6, rows_in_order<double>(vtk_order, order));
}

}  // namespace

std::string write_fields_vtu(const TetMesh& rest, const DeformResult& result,
                             const StressField* stress, const FileOrder& order) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "  <UnstructuredGrid>\n    <Piece NumberOfPoints=\"" +
      std::to_string(rest.vertex_count()) + "\" NumberOfCells=\"" +
      std::to_string(rest.tet_count()) + "\">\n";
  xml += "      <Points>\n";
  append_array(xml, "Points", 3, rows_in_order<double>(rest.vertices, order.vertices));
  xml += "      </Points>\n";
  append_cells(xml, rest, order);
  xml += "      <PointData Scalars=\"G\">\n";
  append_array(xml, "G", 1, rows_in_order<double>(result.field.value, order.vertices));
  append_array(xml, "deformed", 3, rows_in_order<double>(result.deformed, order.vertices));
  xml += "      </PointData>\n      <CellData>\n";
  append_array(xml, "lpd", 3, rows_in_order<double>(result.field.print_direction, order.tets));
  append_array(xml, "quaternion", 4, rows_in_order<double>(result.rotation, order.tets));
  if (stress != nullptr) append_stress(xml, rest, *stress, order.tets);
  xml += "      </CellData>\n    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n";
  return xml;
}

}  // namespace s3
