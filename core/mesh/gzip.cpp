// The format: RFC 1952.
#include "mesh/gzip.h"

#include <algorithm>

#include "base/error.h"
#include "mesh/inflate.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

constexpr std::size_t kHeader = 10, kTrailer = 8;
constexpr int kHeaderCrc = 2, kExtra = 4, kName = 8, kComment = 16;

[[noreturn]] void fail(std::string_view file_name, const std::string& what) {
  throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file", std::string(file_name) + ": " + what,
              "Unpack the file with gunzip, or pack it again");
}

std::uint32_t number(std::string_view text, std::size_t at, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes; i-- > 0;)
    value = value << 8 | static_cast<unsigned char>(text[at + i]);
  return value;
}

}  // namespace

bool is_gzip(std::span<const std::byte> bytes) {
  return as_text(bytes).starts_with("\x1f\x8b\x08");
}

std::string unpack_gzip(std::span<const std::byte> bytes, std::string_view file_name) {
  const std::string_view text = as_text(bytes);
  if (text.size() < kHeader + kTrailer) fail(file_name, "the gzip file is cut short");
  const int flags = static_cast<unsigned char>(text[3]);
  std::size_t at = kHeader;
  if (flags & kExtra) at += 2 + number(text, at, 2);
  for (const int field : {kName, kComment})
    if (flags & field) at = std::min(text.find('\0', std::min(at, text.size())), text.size()) + 1;
  if (flags & kHeaderCrc) at += 2;
  if (at > text.size() - kTrailer) fail(file_name, "the gzip file is cut short");
  const std::string_view packed = text.substr(at, text.size() - kTrailer - at);
  const std::uint32_t crc = number(text, text.size() - 8, 4),
                      size = number(text, text.size() - 4, 4);
  if (!is_plausible_size(size, packed.size()))
    fail(file_name, "the gzip file claims to unpack from " + std::to_string(packed.size()) +
                        " to " + std::to_string(size) + " bytes, which no model does");
  std::optional<std::string> content = inflate(packed, size);
  if (!content || crc32(*content) != crc) fail(file_name, "the gzip file is damaged");
  return std::move(*content);
}

}  // namespace s3
