#include "job.h"

#include <algorithm>
#include <string_view>

#include "base/error.h"
#include "files.h"
#include "params/param_visitors.h"

namespace fs = std::filesystem;

namespace s3::cli {
namespace {

bool is_bundled(const std::string& machine) {
  const auto names = bundled_machines();
  return std::find(names.begin(), names.end(), machine) != names.end();
}

void make_absolute(std::string& path, const fs::path& folder) {
  if (path.empty()) return;
  std::error_code error;
  const fs::path full = fs::weakly_canonical(folder / path, error);
  path = error ? (folder / path).string() : full.string();
}

/// Paths that the last source has changed count from `folder`.
void make_paths_absolute(Params& params, const Params& before, const fs::path& folder) {
  if (params.model != before.model) make_absolute(params.model, folder);
  if (params.strength.stress_file != before.strength.stress_file)
    make_absolute(params.strength.stress_file, folder);
  if (params.strength.load_case != before.strength.load_case)
    make_absolute(params.strength.load_case, folder);
  if (params.strength.critical_region != before.strength.critical_region)
    make_absolute(params.strength.critical_region, folder);
  if (params.objectives.surface_region != before.objectives.surface_region)
    make_absolute(params.objectives.surface_region, folder);
  std::string& machine = params.machine.machine;
  if (machine != before.machine.machine && !is_bundled(machine) && fs::exists(folder / machine))
    make_absolute(machine, folder);
}

std::string_view as_text(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Params collect_params(const RunOptions& options) {
  Params params;
  for (const std::string& config : options.configs) {
    const Params before = params;
    const auto bytes = read_file(config);
    from_json(list_params(params), as_text(bytes), config);
    make_paths_absolute(params, before, fs::absolute(config).parent_path());
  }
  const Params before = params;
  for (const auto& [key, text] : options.flags) set_by_key(list_params(params), key, text);
  if (!options.model.empty()) params.model = options.model;
  make_paths_absolute(params, before, fs::current_path());
  if (params.model.empty())
    throw Error(ErrorKind::input, Stage::mesh, "params.no_model", "there is no model to slice",
                "name a file: s3slice run MODEL -o OUTDIR");
  return params;
}

MachineProfile load_machine(const std::string& machine) {
  if (is_bundled(machine) || !fs::exists(machine)) return bundled_machine(machine);
  return parse_machine_profile(as_text(read_file(machine)), machine);
}

void set_job(Pipeline& pipeline, const Params& params) {
  // Known before any stage has run: better said now than after minutes.
  if (params.objectives.strength > 0 && params.strength.stress_file.empty() &&
      params.strength.load_case.empty())
    throw Error(ErrorKind::input, Stage::fea, "fea.no_stress",
                "objectives.strength is above 0, but there is no stress field",
                "name a file with strength.load_case or strength.stress_file, or set "
                "objectives.strength to 0");
  pipeline.set_params(params, load_machine(params.machine.machine));
  pipeline.set_model(read_file(params.model), params.model);
  if (!params.strength.stress_file.empty())
    pipeline.set_stress(read_file(params.strength.stress_file), params.strength.stress_file);
  if (!params.strength.load_case.empty()) {
    const auto bytes = read_file(params.strength.load_case);
    read_load_cases(bytes, params.strength.load_case);  // a fault in it is better said now too
    pipeline.set_load_case(bytes, params.strength.load_case);
  }
  if (const std::string& name = params.strength.critical_region; !name.empty()) {
    const auto bytes = read_file(name);
    read_region_file(bytes, name, Stage::fea);
    pipeline.set_critical_region(bytes, name);
  }
  if (const std::string& name = params.objectives.surface_region; !name.empty()) {
    const auto bytes = read_file(name);
    read_region_file(bytes, name, Stage::objectives);
    pipeline.set_surface_region(bytes, name);
  }
}

fs::path output_folder(const RunOptions& options) {
  if (!options.output.empty()) return options.output;
  if (options.model.empty() && !options.configs.empty())
    return fs::absolute(options.configs.back()).parent_path();  // repeats a job where it was
  throw Error(ErrorKind::input, Stage::exporting, "params.no_output",
              "there is no folder to write to", "name one: s3slice run MODEL -o OUTDIR");
}

}  // namespace s3::cli
