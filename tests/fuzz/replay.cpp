// Runs the inputs in corpus/NAME through the fuzz target NAME, without a fuzzer: what one found
// once must stay repaired, and no small file may take a second or 200 MB.
//   s3replay tests/fuzz/corpus
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <sys/resource.h>

#include "fuzz.h"

namespace fs = std::filesystem;

// S3_FUZZ_TARGETS is "X(stl) X(obj) …": CMake knows the targets by their files, and gives each its
// own name in this program.
#define X(name) extern "C" int fuzz_##name(const std::uint8_t* data, std::size_t size);
S3_FUZZ_TARGETS
#undef X

namespace {

struct Target {
  const char* name;
  int (*run)(const std::uint8_t* data, std::size_t size);
};

#define X(name) {#name, fuzz_##name},
constexpr Target kTargets[] = {S3_FUZZ_TARGETS};
#undef X

constexpr double kMostSeconds = 1;
constexpr long kMostKilobytes = 200 * 1024;

std::vector<std::uint8_t> content_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// @return whether the file passed; a target that breaks its promise aborts the program
bool replay(const Target& target, const fs::path& path) {
  const std::vector<std::uint8_t> bytes = content_of(path);
  std::fprintf(stderr, "%s\n", path.c_str());  // the last line names the file that aborts
  const std::clock_t start = std::clock();
  target.run(bytes.data(), bytes.size());
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  if (seconds > kMostSeconds) std::printf("%s took %.1f s\n", path.c_str(), seconds);
  return seconds <= kMostSeconds;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: s3replay tests/fuzz/corpus\n");
    return 2;
  }
  int passed = 0, failed = 0;
  for (const Target& target : kTargets) {
    std::vector<fs::path> paths;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(fs::path(argv[1]) / target.name, error))
      paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    for (const fs::path& path : paths) ++(replay(target, path) ? passed : failed);
    if (paths.empty()) {
      std::printf("no inputs for %s\n", target.name);
      ++failed;
    }
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  if (usage.ru_maxrss > kMostKilobytes) {
    std::printf("the inputs took %ld kB\n", usage.ru_maxrss);
    ++failed;
  }
  std::printf("%d passed, %d failed\n", passed, failed);
  return failed == 0 ? 0 : 1;
}
