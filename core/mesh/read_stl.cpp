#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "mesh/model_parts.h"
#include "mesh/read_mesh.h"
#include "mesh/text_scanner.h"
#include "mesh/weld.h"

namespace s3 {

namespace {

constexpr std::size_t kHeaderBytes = 84, kTriangleBytes = 50;

std::uint32_t little_endian_u32(const std::byte* bytes) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | std::to_integer<std::uint32_t>(bytes[i]);
  return value;
}

double little_endian_float(const std::byte* bytes) {
  const std::uint32_t bits = little_endian_u32(bytes);
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

[[noreturn]] void bad_binary(std::string_view file_name, const std::string& what) {
  throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file", std::string(file_name) + ": " + what,
              "The file is damaged or was cut short; export the model again");
}

TriMesh welded(Welder& welder, std::vector<Index>& corners) {
  TriMesh mesh;
  mesh.vertices = welder.take();
  mesh.triangles =
      Eigen::Map<const Triangles>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
  return mesh;
}

}  // namespace

bool has_binary_stl_size(std::span<const std::byte> bytes) {
  return bytes.size() >= kHeaderBytes &&
         bytes.size() == kHeaderBytes + kTriangleBytes * static_cast<std::uint64_t>(
                                                             little_endian_u32(bytes.data() + 80));
}

TriMesh read_stl_binary(std::span<const std::byte> bytes, std::string_view file_name) {
  if (bytes.size() < kHeaderBytes)
    bad_binary(file_name,
               "a binary STL has at least 84 bytes, this file has " + std::to_string(bytes.size()));
  const std::size_t count = little_endian_u32(bytes.data() + 80);
  const std::size_t held = (bytes.size() - kHeaderBytes) / kTriangleBytes;
  if (count > held)
    bad_binary(file_name, "the header promises " + std::to_string(count) +
                              " triangles, the file holds " + std::to_string(held));
  // Some bytes of another program's may follow, but a whole number of triangles is no accident.
  if (count < held && bytes.size() == kHeaderBytes + kTriangleBytes * held)
    bad_binary(file_name, "the header counts " + std::to_string(count) +
                              " triangles, the file holds " + std::to_string(held));
  Welder welder(count / 2);
  std::vector<Index> corners;
  corners.reserve(3 * count);
  for (std::size_t t = 0; t < count; ++t) {
    const std::byte* corner = bytes.data() + kHeaderBytes + t * kTriangleBytes + 12;
    for (int i = 0; i < 3; ++i, corner += 12) {
      const Vec3 p(little_endian_float(corner), little_endian_float(corner + 4),
                   little_endian_float(corner + 8));
      if (!p.allFinite())
        bad_binary(file_name, "triangle " + std::to_string(t) +
                                  " has a coordinate that is not a number (byte " +
                                  std::to_string(corner - bytes.data()) + ")");
      corners.push_back(welder.add(p));
    }
  }
  return welded(welder, corners);
}

ModelFile read_stl_ascii(std::span<const std::byte> bytes, std::string_view file_name) {
  LineReader reader(as_text(bytes), file_name);
  Welder welder;
  std::vector<Index> corners, solid_of_triangle;
  std::vector<std::string> names;
  int open_corners = -1;  // −1 outside a loop
  bool ended = false;
  while (reader.next()) {
    const std::string keyword = lower_case(take_word(reader.line()));
    if (keyword == "vertex") {
      if (open_corners < 0) reader.fail("a vertex outside 'outer loop'");
      if (++open_corners > 3) reader.fail("a facet with more than three corners");
      corners.push_back(welder.add(reader.take_point()));
    } else if (keyword == "outer") {
      if (open_corners >= 0) reader.fail("'outer loop' inside a loop");
      open_corners = 0;
    } else if (keyword == "endloop") {
      if (open_corners != 3)
        reader.fail("a facet with " + std::to_string(std::max(open_corners, 0)) + " corners");
      open_corners = -1;
      if (names.empty()) names.emplace_back();
      solid_of_triangle.push_back(static_cast<Index>(names.size() - 1));
    } else if (keyword == "endsolid" || keyword == "end") {
      ended = true;
    } else if (keyword == "solid") {
      ended = false;
      names.emplace_back(trimmed(reader.line()));
    } else if (keyword != "facet" && keyword != "endfacet") {
      reader.fail("unknown word '" + keyword.substr(0, 40) + "'");
    }
  }
  if (open_corners >= 0 || !ended) reader.fail("the file ends before 'endsolid'");
  ModelFile model;
  model.surface = welded(welder, corners);
  set_parts(model, solid_of_triangle, names);
  return model;
}

}  // namespace s3
