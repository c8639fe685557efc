// What a run is asked for: parameters from files and flags, and the files that they name.
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "motion/machine_profile.h"
#include "pipeline/params.h"
#include "pipeline/pipeline.h"

namespace s3::cli {

struct RunOptions {
  std::string model, output;
  std::vector<std::string> configs;
  std::vector<std::pair<std::string, std::string>>
      flags;  // parameter key and text, in the order given
  bool quiet = false;
  int threads = 0;  // 0: as many as there are processors
  std::string until;
};

struct SweepOptions {
  RunOptions run;                    // without `until`
  std::vector<std::string> weights;  // texts of triples; empty for a grid
  int grid = 4;                      // steps along each side of the triangle
  bool strain = false;               // print every triple and analyse its strain
};

/// Config files in their order, then flags, then the MODEL argument. Paths in a config file count
/// from its folder; all paths become absolute, so that the job can be repeated from anywhere.
/// @throws Error "params.…"
Params collect_params(const RunOptions& options);

/// The bundled profile of that name, or the profile file.
MachineProfile load_machine(const std::string& machine);

/// Gives the pipeline its model, stress and parameters.
void set_job(Pipeline& pipeline, const Params& params);

/// -o, or the folder of the job.json that is repeated.
std::filesystem::path output_folder(const RunOptions& options);

}  // namespace s3::cli
