#include "progress_line.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace s3::cli {

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() {
  clear();
}

void ProgressLine::clear() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

void ProgressLine::show(Stage stage, double fraction) {
  if (quiet_ || !terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  constexpr auto kLeastPause = std::chrono::milliseconds(50);
  if (drawn_ && now - last_ < kLeastPause) return;
  last_ = now;
  const double percent = 100 * std::clamp(fraction, 0.0, 1.0);
  std::fprintf(stderr, "\r\033[K%-16s %3.0f %%", std::string(stage_name(stage)).c_str(), percent);
  std::fflush(stderr);
  drawn_ = true;
}

void ProgressLine::stage_done(const StageRecord& record) {
  if (quiet_) return;
  clear();
  std::fprintf(stderr, "%-16s %8.2f s\n", std::string(stage_name(record.stage)).c_str(),
               record.seconds);
  for (const Warning& warning : record.warnings)
    std::fprintf(stderr, "  warning: %s [%s]\n", warning.message.c_str(), warning.code.c_str());
}

void ProgressLine::triple_done(const std::string& name, double cpu_seconds,
                               const std::string& error) {
  if (quiet_) return;
  clear();
  if (error.empty()) {
    std::fprintf(stderr, "%-28s %8.2f CPU s\n", name.c_str(), cpu_seconds);
  } else {
    std::fprintf(stderr, "%-28s failed: %s\n", name.c_str(), error.c_str());
  }
}

}  // namespace s3::cli
