#include <atomic>
#include <csignal>
#include <thread>

#include "commands.h"

namespace s3::cli {
namespace {

// A signal handler has no other way to what it must change.
std::atomic<std::atomic<bool>*> cancel_flag{nullptr};

void on_interrupt(int signal) {
  if (auto* flag = cancel_flag.load()) flag->store(true);
  std::signal(signal, SIG_DFL);
}

}  // namespace

InterruptibleContext::InterruptibleContext(int threads) : context(threads) {
  cancel_flag = &context.cancel_requested;
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

InterruptibleContext::~InterruptibleContext() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  cancel_flag = nullptr;
}

int thread_count(int wanted) {
  if (wanted > 0) return wanted;
  const unsigned processors = std::thread::hardware_concurrency();
  return processors > 0 ? static_cast<int>(processors) : 1;
}

}  // namespace s3::cli
