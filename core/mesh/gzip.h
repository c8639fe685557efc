// Files packed by gzip.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace s3 {

bool is_gzip(std::span<const std::byte> bytes);

/// Unpacks a file of one member, which is what the program gzip makes.
/// @throws Error "mesh.bad_file" when it is damaged, or claims to unpack to more than a mesh does
std::string unpack_gzip(std::span<const std::byte> bytes, std::string_view file_name);

}  // namespace s3
