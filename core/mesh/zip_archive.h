// The files in a ZIP archive, as 3MF needs them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

namespace s3 {

/// Reads the directory of an archive in memory and unpacks its files one by one. Sizes are those of
/// the directory, and are checked before anything is unpacked: one that claims to unpack to more
/// than a mesh plausibly does, or whose files overlap, is refused.
class ZipArchive {
 public:
  /// @param file_name  for messages
  /// @throws Error "mesh.bad_file" without a directory in range, and for ZIP64
  ZipArchive(std::span<const std::byte> bytes, std::string_view file_name);

  bool has(const std::string& name) const { return entries_.count(name) == 1; }
  /// The content of a file, stored or deflated. Each file can be taken once.
  /// @throws Error "mesh.bad_file" when it is missing, damaged, encrypted or packed otherwise
  std::string take(const std::string& name);

 private:
  struct Entry {
    std::uint32_t flags, method, crc, packed, size, offset;
  };

  [[noreturn]] void fail(const std::string& what) const;
  std::uint32_t number(std::size_t at, int bytes) const;
  std::size_t directory_end() const;

  std::string_view text_, file_name_;
  std::map<std::string, Entry, std::less<>> entries_;
  std::uint64_t packed_taken_ = 0, size_taken_ = 0;
};

}  // namespace s3
