#include "base/error.h"
#include "mesh/mesh_builder.h"
#include "mesh/read_mesh.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

constexpr std::size_t kLeastBytesPerLine =
    6;  // "0 0 0\n": what a vertex or a triangle takes at least

std::int64_t take_count(LineReader& reader, std::string_view what) {
  const std::int64_t count = reader.take_integer(what);
  if (count < 0 || static_cast<std::uint64_t>(count) > reader.bytes_left() / kLeastBytesPerLine + 1)
    reader.fail("the file is too short for " + std::to_string(count) + " " + std::string(what));
  return count;
}

// OFF, COFF, NOFF, STOFF …: what follows the three coordinates of a vertex is skipped with the rest
// of its line.
void take_header(LineReader& reader) {
  std::string_view line = reader.line();
  const std::string_view keyword = take_word(line);
  if (!keyword.ends_with("OFF")) return;  // the keyword is optional
  const std::string_view prefix = keyword.substr(0, keyword.size() - 3);
  if (prefix.find_first_not_of("STCN") != std::string_view::npos)
    reader.fail("'" + std::string(keyword.substr(0, 40)) + "' is not three-dimensional");
  reader.line() = line;
  if (lower_case(take_word(line)) == "binary")
    throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file", "A binary OFF file",
                "Export the model as text OFF or as STL");
  if (reader.line().find_first_not_of(" \t") == std::string_view::npos && !reader.next('#'))
    reader.fail("the file ends before its counts");
}

}  // namespace

TriMesh read_off(std::span<const std::byte> bytes, std::string_view file_name) {
  LineReader reader(as_text(bytes), file_name);
  if (!reader.next('#')) reader.fail("the file is empty");
  take_header(reader);
  const std::int64_t vertices = take_count(reader, "vertices");
  const std::int64_t faces = take_count(reader, "faces");

  MeshBuilder builder;
  for (std::int64_t v = 0; v < vertices; ++v) {
    if (!reader.next('#'))
      reader.fail("the file ends after " + std::to_string(v) + " of " + std::to_string(vertices) +
                  " vertices");
    builder.add_vertex(reader.take_point());
  }
  const auto take_corner = [&] {
    const std::int64_t index = reader.take_integer("a vertex number");
    if (index < 0 || index >= vertices)
      reader.fail("vertex " + std::to_string(index) + " of " + std::to_string(vertices));
    return static_cast<Index>(index);
  };
  for (std::int64_t f = 0; f < faces; ++f) {
    if (!reader.next('#'))
      reader.fail("the file ends after " + std::to_string(f) + " of " + std::to_string(faces) +
                  " faces");
    const std::int64_t corners = reader.take_integer("a number of corners");
    if (corners < 3) reader.fail("a face with " + std::to_string(corners) + " corners");
    const Index first = take_corner();
    Index previous = take_corner();
    for (std::int64_t i = 2; i < corners; ++i) {
      const Index corner = take_corner();
      builder.add_triangle(first, previous, corner);
      previous = corner;
    }
  }
  return builder.take();
}

}  // namespace s3
