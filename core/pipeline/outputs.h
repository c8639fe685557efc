// The files of OUTDIR, stage by stage.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "pipeline/pipeline.h"

namespace s3 {

/// One file that can be written now.
struct OutputFile {
  std::string name;  // relative to OUTDIR: "layers/0003.ply"
  Stage stage;       // whose result it is
  std::function<std::string()> content;
};

/// The files that a stage's result goes into, in the order of writing: stress.csv after fea (with a
/// load case), fields.vtu after outer_loop, layers/NNNN.ply after layers, waypoints.csv after
/// waypoints, the machine's programs after export, plots after metrics. Other stages, and those
/// that are not done, have none.
/// @return refers to the pipeline, and holds until it runs or changes
std::vector<OutputFile> stage_files(const Pipeline& pipeline, Stage stage);

/// job.json: the effective configuration.
std::string job_json(const Pipeline& pipeline);

/// What the program knows and the pipeline does not.
struct RunFigures {
  std::string model_file;
  int threads = 1;
  double peak_memory_mb = 0;
  double export_seconds = 0, total_seconds = 0;
};

/// report.json. What was not computed is null.
std::string report_json(const Pipeline& pipeline, const RunFigures& figures);

/// The table that a run ends with: curved and planar layers side by side.
std::string summary_table(const Pipeline& pipeline);

}  // namespace s3
