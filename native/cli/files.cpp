#include "files.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace fs = std::filesystem;

namespace s3::cli {
namespace {

std::string last_error() {
  return std::strerror(errno);
}

/// Names that runs write, beside layers/NNNN.ply.
bool is_result(const fs::path& path) {
  for (const char* name :
       {"report.json", "job.json", "fields.vtu", "waypoints.csv", "program.gcode", "program.script",
        "duet.gcode", "joints.csv", "support_free.svg", "surface_quality.svg", "strength.svg",
        "thickness.svg", "strain.svg", "residual.svg", "sweep.csv", "sweep.json", "sweep.svg"})
    if (path.filename() == name) return true;
  return false;
}

bool is_layer(const fs::path& path) {
  const std::string stem = path.stem().string();
  return path.extension() == ".ply" && stem.size() >= 4 &&
         stem.find_first_not_of("0123456789") == std::string::npos;
}

void remove_files(const fs::path& folder, bool (*wanted)(const fs::path&)) {
  std::error_code error;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(error) && wanted(entry.path())) found.push_back(entry.path());
  for (const fs::path& path : found) fs::remove(path, error);
}

}  // namespace

std::vector<std::byte> read_file(const fs::path& path) {
  const auto fail = [&](const std::string& why) -> Error {
    return {ErrorKind::input, Stage::mesh, "mesh.no_file",
            path.string() + " cannot be read: " + why, "check the path and its permissions"};
  };
  std::error_code error;
  if (fs::is_directory(path, error)) throw fail("it is a folder");
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw fail(last_error());
  std::vector<std::byte> bytes;
  constexpr std::size_t kBlock = 1 << 20;
  for (;;) {
    const std::size_t size = bytes.size();
    bytes.resize(size + kBlock);
    in.read(reinterpret_cast<char*>(bytes.data() + size), kBlock);
    const auto count = static_cast<std::size_t>(in.gcount());
    bytes.resize(size + count);
    if (count < kBlock) break;
  }
  if (in.bad()) throw fail(last_error());
  return bytes;
}

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error, ignored;
  fs::create_directories(folder_, error);
  if (fs::is_directory(folder_, ignored)) return;
  throw Error(ErrorKind::input, Stage::exporting, "export.no_folder",
              "the folder " + folder_.string() + " cannot be made: " + error.message(),
              "choose another one with -o");
}

void OutputFolder::remove_results() {
  remove_files(folder_, is_result);
  remove_files(folder_ / "layers", is_layer);
}

void OutputFolder::write(const std::string& name, const std::string& content) {
  const fs::path path = folder_ / fs::path(name);
  const fs::path temporary = path.parent_path() / (path.filename().string() + ".part");
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  errno = 0;
  bool written = false;
  {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    written = !out.fail();
  }
  const std::string why = last_error();
  if (written) {
    fs::rename(temporary, path, error);
    if (!error) return;
  }
  const std::string reason = written ? error.message() : why;
  fs::remove(temporary, error);
  throw Error(ErrorKind::input, Stage::exporting, "export.no_write",
              path.string() + " cannot be written: " + reason,
              "check the space and the permissions there, or choose another folder with -o");
}

}  // namespace s3::cli
