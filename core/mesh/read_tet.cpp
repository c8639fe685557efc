#include "mesh/read_mesh.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

// "N vertices" or "M tets"; a row takes at least `row_bytes`.
Index take_count(LineReader& reader, std::string_view unit, std::size_t row_bytes) {
  if (!reader.next('#')) reader.fail("the file ends before the number of " + std::string(unit));
  const std::int64_t count = reader.take_integer("the number of " + std::string(unit));
  if (take_word(reader.line()) != unit)
    reader.fail("expected '<number> " + std::string(unit) + "'");
  if (count < 0 || static_cast<std::uint64_t>(count) > reader.bytes_left() / row_bytes + 1)
    reader.fail("the file is too short for " + std::to_string(count) + " " + std::string(unit));
  return static_cast<Index>(count);
}

}  // namespace

ModelFile read_tet(std::span<const std::byte> bytes, std::string_view file_name) {
  LineReader reader(as_text(bytes), file_name);
  const Index vertices = take_count(reader, "vertices", 6);
  const Index tets = take_count(reader, "tets", 10);
  ModelFile model;
  model.format = "tet";
  model.is_volume = true;
  model.vertices.resize(vertices, 3);
  model.tets.resize(tets, 4);
  for (Index v = 0; v < vertices; ++v) {
    if (!reader.next('#'))
      reader.fail("the file ends after " + std::to_string(v) + " of " + std::to_string(vertices) +
                  " vertices");
    model.vertices.row(v) = reader.take_point();
  }
  for (Index t = 0; t < tets; ++t) {
    if (!reader.next('#'))
      reader.fail("the file ends after " + std::to_string(t) + " of " + std::to_string(tets) +
                  " tets");
    if (reader.take_integer("the number of corners") != 4) reader.fail("a tet has 4 corners");
    for (int i = 0; i < 4; ++i) {
      const std::int64_t corner = reader.take_integer("a vertex number");
      if (corner < 0 || corner >= vertices)
        reader.fail("vertex " + std::to_string(corner) + " of " + std::to_string(vertices));
      model.tets(t, i) = static_cast<Index>(corner);
    }
  }
  return model;
}

}  // namespace s3
