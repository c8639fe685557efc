#include "mesh/write_mesh.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace s3 {

namespace {

void append_u32(std::string& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

void append_floats(std::string& bytes, const Vec3& p) {
  for (int k = 0; k < 3; ++k) {
    const float value = static_cast<float>(p[k]);
    std::uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    append_u32(bytes, bits);
  }
}

void append_points(std::string& text, const Points& points, const char* prefix) {
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    text += prefix;
    for (int k = 0; k < 3; ++k) {
      if (k > 0) text += ' ';
      append_number(text, points(v, k));
    }
    text += '\n';
  }
}

template <class Rows>
void append_indices(std::string& text, const Rows& rows, const char* prefix, Index base) {
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    text += prefix;
    for (Eigen::Index k = 0; k < rows.cols(); ++k) text += ' ' + std::to_string(rows(r, k) + base);
    text += '\n';
  }
}

}  // namespace

void append_number(std::string& text, double value) {
  char buffer[40];
  for (int digits = 15; digits <= 17; ++digits) {
    std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
    if (std::strtod(buffer, nullptr) == value) break;
  }
  text += buffer;
}

std::string write_stl(const TriMesh& mesh) {
  std::string bytes = "binary STL, mm";
  bytes.resize(80, ' ');
  bytes.reserve(84 + 50 * static_cast<std::size_t>(mesh.triangles.rows()));
  append_u32(bytes, static_cast<std::uint32_t>(mesh.triangles.rows()));
  const Directions normals = triangle_normals(mesh);
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    append_floats(bytes, normals.row(f));
    for (int i = 0; i < 3; ++i) append_floats(bytes, mesh.vertices.row(mesh.triangles(f, i)));
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string write_obj(const TriMesh& mesh) {
  std::string text;
  append_points(text, mesh.vertices, "v ");
  append_indices(text, mesh.triangles, "f", 1);
  return text;
}

std::string write_off(const TriMesh& mesh) {
  std::string text = "OFF\n" + std::to_string(mesh.vertices.rows()) + " " +
                     std::to_string(mesh.triangles.rows()) + " 0\n";
  append_points(text, mesh.vertices, "");
  append_indices(text, mesh.triangles, "3", 0);
  return text;
}

std::string write_tet(const Points& vertices, const Tets& tets) {
  std::string text =
      std::to_string(vertices.rows()) + " vertices\n" + std::to_string(tets.rows()) + " tets\n";
  append_points(text, vertices, "");
  append_indices(text, tets, "4", 0);
  return text;
}

}  // namespace s3
