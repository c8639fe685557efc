// The format: PKWARE, ".ZIP File Format Specification" (APPNOTE), version 6.3.
#include "mesh/zip_archive.h"

#include "base/error.h"
#include "mesh/inflate.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

constexpr std::size_t kLocalHeader = 30, kDirectoryEntry = 46, kDirectoryEnd = 22;
constexpr std::uint32_t kStored = 0, kDeflated = 8;

}  // namespace

void ZipArchive::fail(const std::string& what) const {
  throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file", std::string(file_name_) + ": " + what,
              "The file is damaged or was cut short; export the model again, or as STL");
}

// Little endian; the caller has checked that it lies in the file.
std::uint32_t ZipArchive::number(std::size_t at, int bytes) const {
  std::uint32_t value = 0;
  for (int i = bytes - 1; i >= 0; --i)
    value = value << 8 | static_cast<unsigned char>(text_[at + static_cast<std::size_t>(i)]);
  return value;
}

// The end record lies before a comment of at most 64 kB.
std::size_t ZipArchive::directory_end() const {
  if (text_.size() < kDirectoryEnd) fail("the archive has no directory");
  const std::size_t found = text_.rfind("PK\x05\x06", text_.size() - kDirectoryEnd);
  if (found == std::string_view::npos || text_.size() - found > kDirectoryEnd + 0xffff)
    fail("the archive has no directory at its end");
  return found;
}

ZipArchive::ZipArchive(std::span<const std::byte> bytes, std::string_view file_name)
    : text_(as_text(bytes)), file_name_(file_name) {
  const std::size_t end = directory_end();
  const std::uint32_t count = number(end + 10, 2), size = number(end + 12, 4);
  std::size_t at = number(end + 16, 4);
  if (count == 0xffff || size == 0xffffffff || at == 0xffffffff) fail("a ZIP64 archive");
  if (at > end || size > end - at) fail("the archive's directory lies outside the file");
  for (std::uint32_t i = 0; i < count; ++i) {
    if (end - at < kDirectoryEntry || text_.substr(at, 4) != "PK\x01\x02")
      fail("the archive's directory is damaged at byte " + std::to_string(at));
    const Entry entry = {number(at + 8, 2),  number(at + 10, 2), number(at + 16, 4),
                         number(at + 20, 4), number(at + 24, 4), number(at + 42, 4)};
    const std::size_t name_size = number(at + 28, 2);
    const std::size_t whole = kDirectoryEntry + name_size + number(at + 30, 2) + number(at + 32, 2);
    if (whole > end - at) fail("the archive's directory is cut short");
    const std::string name(text_.substr(at + kDirectoryEntry, name_size));
    if (!entries_.emplace(name, entry).second) fail("the archive holds '" + name + "' twice");
    at += whole;
  }
}

std::string ZipArchive::take(const std::string& name) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) fail("the archive holds no '" + name + "'");
  const Entry entry = found->second;
  entries_.erase(found);
  if (entry.flags & 1) fail("'" + name + "' is encrypted");
  if (entry.offset > text_.size() || text_.size() - entry.offset < kLocalHeader ||
      text_.substr(entry.offset, 4) != "PK\x03\x04")
    fail("'" + name + "' lies outside the archive");
  const std::size_t begin =
      entry.offset + kLocalHeader + number(entry.offset + 26, 2) + number(entry.offset + 28, 2);
  if (begin > text_.size() || entry.packed > text_.size() - begin)
    fail("'" + name + "' lies outside the archive");
  packed_taken_ += entry.packed;
  size_taken_ += entry.size;
  if (packed_taken_ > text_.size()) fail("the archive's files overlap");
  if (!is_plausible_size(size_taken_, text_.size()))
    fail("'" + name + "' claims to unpack from " + std::to_string(entry.packed) + " to " +
         std::to_string(entry.size) + " bytes, which no model does");
  const std::string_view packed = text_.substr(begin, entry.packed);
  std::optional<std::string> content;
  if (entry.method == kStored && entry.packed == entry.size)
    content = std::string(packed);
  else if (entry.method == kDeflated)
    content = inflate(packed, entry.size);
  else
    fail("'" + name + "' is packed by method " + std::to_string(entry.method));
  if (!content || crc32(*content) != entry.crc) fail("'" + name + "' is damaged");
  return std::move(*content);
}

}  // namespace s3
