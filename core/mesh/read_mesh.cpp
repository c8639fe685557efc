#include "mesh/read_mesh.h"

#include <limits>

#include "base/error.h"
#include "mesh/gzip.h"
#include "mesh/read_3mf.h"
#include "mesh/read_vtu.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

// Without that of gzip, which read_model() has unpacked.
std::string extension_of(std::string_view file_name) {
  if (lower_case(file_name).ends_with(".gz")) file_name.remove_suffix(3);
  const std::size_t dot = file_name.rfind('.');
  return dot == std::string_view::npos ? "" : lower_case(file_name.substr(dot + 1));
}

// Formats that people are likely to bring and that this program does not read.
std::string known_stranger(std::string_view text) {
  if (text.starts_with("# vtk DataFile")) return "a legacy VTK file; save it as VTU";
  if (text.starts_with("ISO-10303-21")) return "a STEP file; export a triangle mesh from it";
  return {};
}

bool is_obj_keyword(std::string_view word) {
  for (const std::string_view known :
       {"v", "vn", "vt", "vp", "f", "g", "o", "s", "mtllib", "usemtl"})
    if (word == known) return true;
  return false;
}

// The format that the first words of the text announce; empty when they announce none.
std::string format_from_content(std::span<const std::byte> bytes) {
  const std::string_view text = as_text(bytes);
  if (text.starts_with("ply\n") || text.starts_with("ply\r\n")) return "ply";
  if (text.starts_with("$MeshFormat")) return "msh";
  if (text.starts_with("PK\x03\x04")) return "3mf";
  if (has_binary_stl_size(bytes) && bytes.size() > 84) return "stl-binary";
  LineReader reader(text, "");
  if (!reader.next('#')) return {};
  std::string_view line = reader.line();
  const std::string_view first = take_word(line), second = take_word(line);
  if (lower_case(first) == "solid") return "stl-ascii";
  if (first.ends_with("OFF") && first.size() <= 7) return "off";
  if (first.starts_with("<?xml") || first.starts_with("<VTKFile")) return "vtu";
  if (second == "vertices" && parse_integer(first)) return "tet";
  if (is_obj_keyword(first)) return "obj";
  return {};
}

std::string format_from_extension(const std::string& extension) {
  if (extension == "stl") return "stl-binary";
  for (const std::string_view known : {"obj", "ply", "3mf", "off", "tet", "msh", "vtu"})
    if (extension == known) return extension;
  return {};
}

[[noreturn]] void unknown_format(std::string_view file_name, const std::string& stranger) {
  throw Error(ErrorKind::input, Stage::mesh, "mesh.unknown_format",
              std::string(file_name) +
                  (stranger.empty() ? " is of no known format" : " looks like " + stranger),
              std::string("Use a surface as ") + kSurfaceFormats + ", or a volume mesh as " +
                  kVolumeFormats);
}

ModelFile volume_of(VtuFile file) {
  ModelFile model;
  model.is_volume = true;
  model.vertices = std::move(file.vertices);
  model.tets = std::move(file.tets);
  return model;
}

}  // namespace

ModelFile read_model(std::span<const std::byte> bytes, std::string_view file_name) {
  std::string unpacked;
  if (is_gzip(bytes)) {
    unpacked = unpack_gzip(bytes, file_name);
    bytes = std::as_bytes(std::span(unpacked));
  }
  std::string format = format_from_content(bytes);
  if (format.empty()) {
    const std::string stranger = known_stranger(as_text(bytes));
    if (!stranger.empty()) unknown_format(file_name, stranger);
    format = format_from_extension(extension_of(file_name));
  }
  ModelFile model;
  if (format == "stl-binary")
    model.surface = read_stl_binary(bytes, file_name);
  else if (format == "stl-ascii")
    model = read_stl_ascii(bytes, file_name);
  else if (format == "obj")
    model = read_obj(bytes, file_name);
  else if (format == "ply")
    model.surface = read_ply(bytes, file_name);
  else if (format == "3mf")
    model = read_3mf(bytes, file_name);
  else if (format == "off")
    model.surface = read_off(bytes, file_name);
  else if (format == "tet")
    model = read_tet(bytes, file_name);
  else if (format == "msh")
    model = read_msh(bytes, file_name);
  else if (format == "vtu")
    model = volume_of(read_vtu(bytes, file_name));
  else
    unknown_format(file_name, {});
  model.format = format;
  if (model.surface.triangles.rows() == 0 && model.tets.rows() == 0)
    throw Error(ErrorKind::input, Stage::mesh, "mesh.empty_file",
                std::string(file_name) + " holds no triangles or tets",
                "Export the model as a mesh, with its faces");
  if (model.part_names.empty()) model.part_names.emplace_back();
  if (model.part_of_triangle.empty())
    model.part_of_triangle.assign(static_cast<std::size_t>(model.surface.triangles.rows()), 0);
  return model;
}

}  // namespace s3
