// Loops over fixed chunks, on threads where there are some. The chunks, and the order in which
// partial results are combined, depend on n and grain only: the answer is the same for every number
// of threads.
#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace s3 {

/// A fixed set of workers; the caller computes too. `threads` = 1 (and every build without threads)
/// runs inline.
class ThreadPool {
 public:
  explicit ThreadPool(int threads = 1);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const;

  /// Calls job(0 … jobs-1), each once, from any thread; returns when all have ended. The first
  /// exception is rethrown. Must not be called from inside a job.
  void run(std::size_t jobs, const std::function<void(std::size_t)>& job);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// body(begin, end) over [0, n) in chunks of `grain`.
template <class Body>
void parallel_for(ThreadPool& pool, std::size_t n, std::size_t grain, Body&& body) {
  const std::size_t chunks = (n + grain - 1) / grain;
  if (chunks <= 1 || pool.threads() == 1) {
    for (std::size_t c = 0; c < chunks; ++c) body(c * grain, std::min(n, (c + 1) * grain));
    return;
  }
  pool.run(chunks, [&](std::size_t c) { body(c * grain, std::min(n, (c + 1) * grain)); });
}

/// Sum over chunks of body(begin, end) -> T, added in the order of the chunks.
template <class T, class Body>
T parallel_sum(ThreadPool& pool, std::size_t n, std::size_t grain, T zero, Body&& body) {
  const std::size_t chunks = (n + grain - 1) / grain;
  std::vector<T> parts(chunks, zero);
  const auto one = [&](std::size_t c) { parts[c] = body(c * grain, std::min(n, (c + 1) * grain)); };
  if (chunks <= 1 || pool.threads() == 1) {
    for (std::size_t c = 0; c < chunks; ++c) one(c);
  } else {
    pool.run(chunks, one);
  }
  T sum = zero;
  for (const T& part : parts) sum += part;
  return sum;
}

}  // namespace s3
