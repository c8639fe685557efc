// ZIP archives of unpacked files, for the tests of 3MF.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "mesh/inflate.h"

namespace s3::test {

inline std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i, value >>= 8) text += static_cast<char>(value & 0xff);
  return text;
}

/// @param files  names and contents
inline std::string stored_zip(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string archive, directory;
  for (const auto& [name, content] : files) {
    const std::string common = little_endian(20, 2) + little_endian(0, 8) +
                               little_endian(crc32(content), 4) + little_endian(content.size(), 4) +
                               little_endian(content.size(), 4) + little_endian(name.size(), 2);
    directory += "PK\x01\x02" + little_endian(20, 2) + common + little_endian(0, 12) +
                 little_endian(archive.size(), 4) + name;
    archive += "PK\x03\x04" + common + little_endian(0, 2) + name + content;
  }
  const std::string count = little_endian(files.size(), 2);
  return archive + directory + "PK\x05\x06" + little_endian(0, 4) + count + count +
         little_endian(directory.size(), 4) + little_endian(archive.size(), 4) +
         little_endian(0, 2);
}

}  // namespace s3::test
