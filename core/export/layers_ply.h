// layers/NNNN.ply: one printed layer component a file, out and back in.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "layers/layer.h"

namespace s3 {

/// Binary little-endian PLY: vertices with double x y z nx ny nz thickness (mm), faces as lists of
/// uchar count and int indices. A comment line holds "layer N iso_value X partial 0|1".
std::string write_layer_ply(const Layer& layer);

/// Reads a file of write_layer_ply() back: surface, normal, thickness, iso_value, layer, partial;
/// the rest stays empty.
/// @throws Error "export.bad_file" for anything else
Layer read_layer_ply(std::span<const std::byte> bytes, std::string_view file_name);

/// "layers/0000.ply" for the component printed first.
std::string layer_file_name(std::size_t position);

}  // namespace s3
