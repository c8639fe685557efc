// 3MF: a ZIP archive of XML. Surfaces with units, objects, components and build items.
#pragma once
#include <cstddef>
#include <span>
#include <string_view>

#include "mesh/read_mesh.h"

namespace s3 {

/// Reads what the file would print: each mesh of each build item is a part, moved by its
/// transforms, in mm. Meshes may lie in several files of the archive (production extension).
/// Materials are left out; what else is left out or converted is a warning. A file whose components
/// multiply far beyond what it holds is refused.
/// @throws Error "mesh.bad_file"
ModelFile read_3mf(std::span<const std::byte> bytes, std::string_view file_name);

}  // namespace s3
