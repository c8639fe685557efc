// The commands of s3slice. Each returns the exit code or throws Error or Cancelled.
#pragma once
#include <string>

#include "base/context.h"
#include "job.h"

namespace s3::cli {

// Exit codes of the program.
constexpr int kDone = 0, kInputWrong = 2, kSlicingFailed = 3, kCancelledCode = 130;

int run_command(const RunOptions& options);
int sweep_command(const SweepOptions& options);
int inspect_command(const std::string& model, bool as_json);
int schema_command();
int evaluate_command(const std::string& folder);

/// The context that Ctrl-C cancels while it lives.
class InterruptibleContext {
 public:
  explicit InterruptibleContext(int threads);
  ~InterruptibleContext();
  InterruptibleContext(const InterruptibleContext&) = delete;
  InterruptibleContext& operator=(const InterruptibleContext&) = delete;

  Context context;
};

/// The number of threads to use for --threads N; 0 takes one for each processor.
int thread_count(int wanted);

}  // namespace s3::cli
