// Unpacks what DEFLATE packed: the parts of a 3MF archive, gzip files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace s3 {

/// Unpacks a raw DEFLATE stream (RFC 1951); bytes behind its end are left out.
/// @param size  what the stream must unpack to; no more memory than this is taken. Streams grow at
///              most 1032 times, so a caller that bounds `size` has bounded the time too
/// @return nothing when the stream is damaged or of another size
std::optional<std::string> inflate(std::string_view packed, std::size_t size);

/// The check sum of ZIP and gzip.
std::uint32_t crc32(std::string_view bytes);

/// Whether `size` unpacked bytes are believable for `packed` bytes of a mesh: text packs to a
/// tenth, at the very best to a hundredth, while bombs reach a thousandth.
bool is_plausible_size(std::uint64_t size, std::uint64_t packed);

}  // namespace s3
