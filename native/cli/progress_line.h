// Progress on stderr: one moving line on a terminal, one line a stage otherwise.
#pragma once
#include <chrono>
#include <string>

#include "base/stage.h"
#include "pipeline/pipeline.h"

namespace s3::cli {

class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Redraws the line at most every 50 ms.
  void show(Stage stage, double fraction);
  void stage_done(const StageRecord& record);
  /// @param error  why it has no figures; empty where it has
  void triple_done(const std::string& name, double cpu_seconds, const std::string& error);

 private:
  void clear();

  bool quiet_, terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace s3::cli
