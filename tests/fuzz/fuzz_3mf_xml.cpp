// The XML of a 3MF file: up to the first zero byte the root, behind it another file of the archive.
#include <string>

#include "fuzz.h"
#include "mesh/read_3mf.h"
#include "mesh/text_scanner.h"
#include "stored_zip.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    const std::string_view text = s3::as_text(bytes);
    const std::size_t end = std::min(text.find('\0'), text.size());
    const std::string archive = s3::test::stored_zip(
        {{"3D/3dmodel.model", std::string(text.substr(0, end))},
         {"3D/other.model", std::string(text.substr(std::min(end + 1, text.size())))}});
    const s3::ModelFile model = s3::read_3mf(std::as_bytes(std::span(archive)), "fuzz");
    s3::fuzz::require_in_range(model.surface.vertices, model.surface.triangles);
    s3::fuzz::require(model.part_of_triangle.size() ==
                      static_cast<std::size_t>(model.surface.triangles.rows()));
    for (const s3::Index part : model.part_of_triangle)
      s3::fuzz::require(part >= 0 && static_cast<std::size_t>(part) < model.part_names.size());
  });
}
