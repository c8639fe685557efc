#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "commands.h"
#include "files.h"
#include "params/param_visitors.h"
#include "pipeline/outputs.h"
#include "progress_line.h"

namespace s3::cli {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts in KiB
}

Stage last_stage(const Pipeline& pipeline, const std::string& name) {
  if (name.empty()) return pipeline.stages().back().stage;
  std::string known;
  for (const StageRecord& record : pipeline.stages()) {
    if (stage_name(record.stage) == name) return record.stage;
    known += known.empty() ? "" : ", ";
    known += stage_name(record.stage);
  }
  throw Error(ErrorKind::input, Stage::mesh, "params.unknown_stage",
              "there is no stage \"" + name + "\"", "--until takes one of " + known);
}

}  // namespace

int run_command(const RunOptions& options) {
  const auto start = Clock::now();
  InterruptibleContext interruptible(thread_count(options.threads));
  Context& ctx = interruptible.context;
  ProgressLine progress(options.quiet);
  ctx.on_progress = [&](Stage stage, double fraction) { progress.show(stage, fraction); };

  Pipeline pipeline;
  const Stage last = last_stage(pipeline, options.until);
  set_job(pipeline, collect_params(options));
  const std::filesystem::path output = output_folder(options);
  std::optional<OutputFolder> folder;
  RunFigures figures{pipeline.params().model, ctx.pool.threads(), 0, 0, 0};
  for (std::size_t i = 0; i < pipeline.stages().size() && pipeline.stages()[i].stage <= last; ++i) {
    const Stage stage = pipeline.stages()[i].stage;
    pipeline.run_to(stage, ctx);
    progress.stage_done(pipeline.stages()[i]);
    const auto export_start = Clock::now();
    if (!folder) {  // the model is one: results of an earlier run make room
      folder.emplace(output);
      folder->remove_results();
      folder->write("job.json", job_json(pipeline));
    }
    for (const OutputFile& file : stage_files(pipeline, stage)) {
      ctx.checkpoint();
      folder->write(file.name, file.content());
    }
    figures.export_seconds += seconds_since(export_start);
  }
  figures.peak_memory_mb = peak_memory_mb();
  figures.total_seconds = seconds_since(start);
  folder->write("report.json", report_json(pipeline, figures));
  if (!options.quiet && pipeline.is_done(Stage::metrics))
    std::fputs(summary_table(pipeline).c_str(), stdout);
  return kDone;
}

int schema_command() {
  Params params;
  std::fputs(json_schema(list_params(params)).c_str(), stdout);
  return kDone;
}

}  // namespace s3::cli
