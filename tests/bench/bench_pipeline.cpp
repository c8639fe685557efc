// Times every stage for given models and thread counts, one JSON object a line.
//   s3bench [--threads 1,2] [--until STAGE] [--any.param value ...] [NAME|FILE ...]
// NAME is a bundled model; a `.tet` or other volume file works like in s3slice run. Without models:
// all bundled ones.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "params/param_visitors.h"
#include "pipeline/pipeline.h"

using namespace s3;

namespace {

struct Options {
  std::vector<int> threads{1};
  std::string until = "metrics";
  std::vector<std::pair<std::string, std::string>> params;
  std::vector<std::string> models;
};

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// The longest time between two checkpoints of the thread that made it: with one thread, how late a
/// cancel could have been answered.
class LongestWait {
 public:
  explicit LongestWait(Context& ctx) : ctx_(ctx) {
    ctx.on_checkpoint = [this] {
      if (std::this_thread::get_id() == thread_) note();
    };
  }
  ~LongestWait() { ctx_.on_checkpoint = nullptr; }
  LongestWait(const LongestWait&) = delete;
  LongestWait& operator=(const LongestWait&) = delete;

  double seconds() {
    note();
    return longest_;
  }

 private:
  using Clock = std::chrono::steady_clock;

  void note() {
    const auto now = Clock::now();
    longest_ = std::max(longest_, std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }

  Context& ctx_;
  std::thread::id thread_ = std::this_thread::get_id();
  Clock::time_point last_ = Clock::now();
  double longest_ = 0;
};

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorKind::input, Stage::mesh, "bench.no_file", "cannot read " + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--", 0) != 0) {
      const std::string bundled = S3_MODELS_DIR "/" + word + ".stl";
      options.models.push_back(std::filesystem::exists(bundled) ? bundled : word);
      continue;
    }
    if (i + 1 == argc)
      throw Error(ErrorKind::input, Stage::mesh, "bench.usage", word + " needs a value");
    const std::string value = argv[++i];
    if (word == "--threads") {
      options.threads.clear();
      std::istringstream list(value);
      for (std::string item; std::getline(list, item, ',');)
        options.threads.push_back(std::max(1, std::atoi(item.c_str())));
    } else if (word == "--until") {
      options.until = value;
    } else {
      options.params.emplace_back(word.substr(2), value);
    }
  }
  if (options.models.empty()) {
    for (const auto& entry : std::filesystem::directory_iterator(S3_MODELS_DIR))
      if (entry.path().extension() == ".stl") options.models.push_back(entry.path().string());
    std::sort(options.models.begin(), options.models.end());
  }
  return options;
}

void bench(const std::string& model, int threads, const Options& options) {
  Params params;
  const ParamList list = list_params(params);
  for (const auto& [key, value] : options.params) set_by_key(list, key, value);
  const std::string text = read_file(model);
  Context ctx(threads);
  Pipeline pipeline;
  pipeline.set_model(bytes_of(text), model);
  if (!params.strength.stress_file.empty()) {
    const std::string stress = read_file(params.strength.stress_file);
    pipeline.set_stress(bytes_of(stress), params.strength.stress_file);
  }
  if (!params.strength.load_case.empty()) {
    const std::string load_case = read_file(params.strength.load_case);
    pipeline.set_load_case(bytes_of(load_case), params.strength.load_case);
  }
  if (const std::string& name = params.strength.critical_region; !name.empty())
    pipeline.set_critical_region(bytes_of(read_file(name)), name);
  if (const std::string& name = params.objectives.surface_region; !name.empty())
    pipeline.set_surface_region(bytes_of(read_file(name)), name);
  pipeline.set_params(params, bundled_machine(params.machine.machine));

  using Clock = std::chrono::steady_clock;
  const auto print = [&](const std::string& stage, double cpu, double wall, double wait) {
    const nlohmann::ordered_json line = {
        {"model", std::filesystem::path(model).filename().string()},
        {"threads", threads},
        {"tets", pipeline.artifacts().rest.tet_count()},
        {"stage", stage},
        {"cpu_s", cpu},
        {"wall_s", wall},
        {"longest_wait_s", wait},
        {"peak_memory_mb", peak_memory_mb()}};
    std::printf("%s\n", line.dump().c_str());
    std::fflush(stdout);
  };
  double longest = 0;
  const double cpu_start = cpu_seconds();
  const auto wall_start = Clock::now();
  const auto wall_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  for (const StageRecord& record : pipeline.stages()) {
    const double cpu = cpu_seconds();
    const auto wall = Clock::now();
    LongestWait wait(ctx);
    pipeline.advance(ctx);
    longest = std::max(longest, wait.seconds());
    print(std::string(stage_name(record.stage)), cpu_seconds() - cpu, wall_since(wall),
          wait.seconds());
    if (stage_name(record.stage) == options.until) break;
  }
  print("total", cpu_seconds() - cpu_start, wall_since(wall_start), longest);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = parse(argc, argv);
    for (const std::string& model : options.models)
      for (const int threads : options.threads) bench(model, threads, options);
    return 0;
  } catch (const Error& error) {
    std::fprintf(stderr, "s3bench: %s %s [%s]\n", error.what(), error.hint.c_str(),
                 error.code.c_str());
    return error.kind == ErrorKind::input ? 2 : 3;
  }
}
