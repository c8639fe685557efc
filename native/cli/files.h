// Files as bytes, in and out.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace s3::cli {

/// @throws Error "mesh.no_file" if it cannot be read
std::vector<std::byte> read_file(const std::filesystem::path& path);

/// The folder that a run writes to. A file appears under its name only when it is complete.
class OutputFolder {
 public:
  /// Makes the folder.
  /// @throws Error "export.no_folder" if that fails
  explicit OutputFolder(std::filesystem::path folder);

  /// Removes what an earlier run left: its files would pass for results of this one.
  void remove_results();
  /// @param name  relative, with slashes; folders in it are made
  /// @throws Error "export.no_write" if it cannot be written
  void write(const std::string& name, const std::string& content);

  const std::filesystem::path& path() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

}  // namespace s3::cli
