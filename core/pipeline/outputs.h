// The files of OUTDIR, stage by stage.
#pragma once
#include <functional>
#include <string>

#include "pipeline/pipeline.h"

namespace s3 {

/// Takes a file's name relative to OUTDIR ("layers/0003.ply") and its content.
using FileSink = std::function<void(const std::string& name, const std::string& content)>;

/// Hands over the files that a stage's result goes into: stress.csv after fea (with a load case),
/// fields.vtu after outer_loop, layers/NNNN.ply after layers, waypoints.csv after waypoints, the
/// machine's programs after export, plots after metrics. Other stages have none.
void write_stage_files(const Pipeline& pipeline, Stage stage, const FileSink& sink);

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
