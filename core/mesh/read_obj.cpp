#include <limits>
#include <map>
#include <utility>

#include "mesh/mesh_builder.h"
#include "mesh/model_parts.h"
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

// The faces by the object and the group that they are in.
class Pieces {
 public:
  void set_object(std::string_view name) { key_.first = name; }
  void set_group(std::string_view name) { key_.second = name; }

  // Gives all triangles from the last call up to `triangles` to the current piece.
  void assign(std::size_t triangles) {
    if (triangles == piece_of_triangle_.size()) return;
    const auto [found, is_new] = numbers_.try_emplace(key_, static_cast<Index>(numbers_.size()));
    if (is_new) names_.emplace_back(key_.first.empty() ? key_.second : key_.first);
    piece_of_triangle_.resize(triangles, found->second);
  }

  void give_to(ModelFile& model) const { set_parts(model, piece_of_triangle_, names_); }

 private:
  std::pair<std::string_view, std::string_view> key_;
  std::map<std::pair<std::string_view, std::string_view>, Index> numbers_;
  std::vector<std::string> names_;
  std::vector<Index> piece_of_triangle_;
};

}  // namespace

ModelFile read_obj(std::span<const std::byte> bytes, std::string_view file_name) {
  LineReader reader(as_text(bytes), file_name);
  MeshBuilder builder;
  Pieces pieces;
  while (reader.next('#')) {
    const std::string_view keyword = take_word(reader.line());
    if (keyword == "v") {
      builder.add_vertex(reader.take_point());
    } else if (keyword == "f") {
      take_polygon(reader, builder);
    } else if (keyword == "o" || keyword == "g") {
      pieces.assign(builder.triangle_count());
      const std::string_view name = trimmed(reader.line());
      keyword == "o" ? pieces.set_object(name) : pieces.set_group(name);
    }
    // Normals, textures, materials, lines: nothing that a solid needs.
  }
  pieces.assign(builder.triangle_count());
  const Index largest = builder.largest_corner();
  if (largest >= 0 && static_cast<std::size_t>(largest) >= builder.vertex_count())
    reader.fail("a face names vertex " + std::to_string(largest + 1LL) + ", the file has " +
                std::to_string(builder.vertex_count()));
  ModelFile model;
  model.surface = builder.take();
  pieces.give_to(model);
  return model;
}

}  // namespace s3
