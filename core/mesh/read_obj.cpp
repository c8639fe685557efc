#include <limits>

#include "mesh/mesh_builder.h"
#include "mesh/read_mesh.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

// "v", "v/vt", "v//vn" or "v/vt/vn"; 1-based, negative counts back from the newest vertex.
Index take_corner(LineReader& reader, std::string_view word, std::size_t vertices) {
  const std::optional<std::int64_t> number = parse_integer(word.substr(0, word.find('/')));
  if (!number || *number == 0)
    reader.fail("expected a vertex number, found '" + std::string(word.substr(0, 40)) + "'");
  const std::int64_t count = static_cast<std::int64_t>(vertices);
  const std::int64_t index = *number > 0 ? *number - 1 : count + *number;
  // Positive numbers may name vertices that follow; read_obj checks them at the end.
  if (index < 0 || index > std::numeric_limits<Index>::max())
    reader.fail("vertex " + std::to_string(*number) + " does not exist");
  return static_cast<Index>(index);
}

void take_polygon(LineReader& reader, MeshBuilder& mesh) {
  std::string_view& line = reader.line();
  Index first = -1, previous = -1;
  int corners = 0;
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line), ++corners) {
    const Index corner = take_corner(reader, word, mesh.vertex_count());
    if (corners == 0) first = corner;
    if (corners >= 2) mesh.add_triangle(first, previous, corner);
    previous = corner;
  }
  if (corners < 3) reader.fail("a face with " + std::to_string(corners) + " corners");
}

}  // namespace

TriMesh read_obj(std::span<const std::byte> bytes, std::string_view file_name) {
  LineReader reader(as_text(bytes), file_name);
  MeshBuilder builder;
  while (reader.next('#')) {
    const std::string_view keyword = take_word(reader.line());
    if (keyword == "v")
      builder.add_vertex(reader.take_point());
    else if (keyword == "f")
      take_polygon(reader, builder);
    // Normals, textures, groups, materials, lines: nothing that a solid needs.
  }
  TriMesh mesh = builder.take();
  if (mesh.triangles.size() > 0 && mesh.triangles.maxCoeff() >= mesh.vertices.rows())
    reader.fail("a face names vertex " + std::to_string(mesh.triangles.maxCoeff() + 1LL) +
                ", the file has " + std::to_string(mesh.vertices.rows()));
  return mesh;
}

}  // namespace s3
