// Model files: surfaces and tet meshes from bytes (Sec. 2). Readers trust nothing in the bytes.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/types.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// The formats that read_model() knows, for messages and help texts.
inline constexpr const char* kSurfaceFormats = "STL, OBJ, PLY, 3MF or OFF";
inline constexpr const char* kVolumeFormats = ".tet, Gmsh .msh or VTU";

/// What a file holds, as it is written there: its own axes, orientation and order. Lengths are the
/// file's too, which count as mm; only formats that name a unit are converted, with a warning.
struct ModelFile {
  std::string format;  // "stl-ascii", "stl-binary", "obj", "ply", "3mf", "off", "tet", "msh", "vtu"
  bool is_volume = false;  // which of the two below is filled
  TriMesh surface;         // surface formats: the union of all parts, each where the file puts it
  std::vector<Index> part_of_triangle;  // #F: the part of each triangle; empty for volumes
  std::vector<std::string> part_names;  // #parts, at least one; "" where the file has no name
  Points vertices;                      // volume formats, in file order
  Tets tets;  // #T×4 in file order; may be of negative volume (make_tet_mesh turns them)
  std::vector<Warning> warnings;  // what the reader converted, guessed or left out
};

/// Reads a model of any known format, also packed by gzip; the content decides which it is, then
/// the extension.
///
/// Polygons become fans of triangles. STL corners with equal coordinates become one vertex; nothing
/// else is changed: inspect_surface() and make_tet_mesh() judge the mesh. Time and memory O(bytes).
/// @param file_name  for the extension and for messages
/// @throws Error "mesh.unknown_format", "mesh.bad_file" (with the line or byte), "mesh.empty_file"
ModelFile read_model(std::span<const std::byte> bytes, std::string_view file_name);

// One reader per format; each throws Error "mesh.bad_file".
/// Solids are parts.
ModelFile read_stl_ascii(std::span<const std::byte> bytes, std::string_view file_name);
TriMesh read_stl_binary(std::span<const std::byte> bytes, std::string_view file_name);
/// Objects and groups are parts, unless they share points.
ModelFile read_obj(std::span<const std::byte> bytes, std::string_view file_name);
TriMesh read_off(std::span<const std::byte> bytes, std::string_view file_name);
/// ASCII and binary of either byte order; elements other than vertices, faces and triangle strips
/// are left out.
TriMesh read_ply(std::span<const std::byte> bytes, std::string_view file_name);
/// The authors' format: "N vertices", "M tets", N lines "x y z", M lines "4 a b c d" (0-based).
ModelFile read_tet(std::span<const std::byte> bytes, std::string_view file_name);

/// Versions 2.2 and 4.1, text and binary: the tets, or without solids the triangles and
/// quadrangles. Nodes that these do not use are left out; elements of higher order give their
/// corners, with a warning. Solids other than tets are an error.
ModelFile read_msh(std::span<const std::byte> bytes, std::string_view file_name);

/// True when the bytes are as long as a binary STL of their own count is: 84 + 50n.
bool has_binary_stl_size(std::span<const std::byte> bytes);

}  // namespace s3
