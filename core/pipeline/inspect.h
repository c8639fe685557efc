// What a model file holds and what repair would do about it, before anything is sliced.
#pragma once
#include <cstddef>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "base/context.h"

namespace s3 {

/// The report of `s3slice inspect --json`: file, format, is_volume, size, counts, defects and
/// repairs with their places (mm, file frame), poses to print it in, warnings. What would be
/// refused is said under `refused`.
/// @throws Error as read_model() and make_tet_mesh(), Cancelled
nlohmann::ordered_json inspect_model(std::span<const std::byte> bytes, const std::string& file_name,
                                     Context& ctx);

}  // namespace s3
