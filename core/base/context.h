// What every stage gets beside its data: threads, progress, cancel, warnings.
#pragma once
#include <atomic>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "base/stage.h"

namespace s3 {

class Context {
 public:
  explicit Context(int threads = 1) : pool(threads, [this] { checkpoint(); }) {}

  /// Its loops over chunks make a checkpoint before each chunk.
  ThreadPool pool;

  /// Called with the stage and its own progress in [0, 1]. May be empty.
  std::function<void(Stage, double)> on_progress;

  /// Set from any thread (or signal handler) to stop the run at the next checkpoint.
  std::atomic<bool> cancel_requested{false};

  std::vector<Warning> warnings;

  /// Called at every checkpoint, from whichever thread computes; may set cancel_requested. For
  /// measurements and tests.
  std::function<void()> on_checkpoint;

  /// Throws Cancelled after a cancel. Call at every phase border and in long loops; a
  /// cancel should be answered within 100 ms.
  void checkpoint() const {
    if (on_checkpoint) on_checkpoint();
    if (cancel_requested.load(std::memory_order_relaxed)) throw Cancelled();
  }

  /// Reports progress within a stage and checks for a cancel. Call from the stage's own thread
  /// only.
  void progress(Stage stage, double fraction) const {
    checkpoint();
    if (on_progress) on_progress(stage, fraction);
  }

  void warn(std::string code, std::string message, std::vector<Vec3> where = {}) {
    warnings.push_back({std::move(code), std::move(message), std::move(where)});
  }
};

}  // namespace s3
