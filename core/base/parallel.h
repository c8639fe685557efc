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
  /// @param before_chunk  called by loops over chunks before each one, from any thread; may throw
  explicit ThreadPool(int threads = 1, std::function<void()> before_chunk = {});
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const;

  /// Calls job(0 … jobs-1), each once, from any thread; returns when all have ended. The first
  /// exception is rethrown. Must not be called from inside a job.
  void run(std::size_t jobs, const std::function<void(std::size_t)>& job);

  void before_chunk() const {
    if (before_chunk_) before_chunk_();
  }

 private:
  struct State;
  std::unique_ptr<State> state_;
  std::function<void()> before_chunk_;
};

/// body(begin, end) over [0, n) in chunks of `grain`.
template <class Body>
void parallel_for(ThreadPool& pool, std::size_t n, std::size_t grain, Body&& body) {
  const std::size_t chunks = (n + grain - 1) / grain;
  const auto one = [&](std::size_t c) {
    pool.before_chunk();
    body(c * grain, std::min(n, (c + 1) * grain));
  };
  if (chunks <= 1 || pool.threads() == 1) {
    for (std::size_t c = 0; c < chunks; ++c) one(c);
    return;
  }
  pool.run(chunks, one);
}

/// Sum over chunks of body(begin, end) -> T, added in the order of the chunks.
template <class T, class Body>
T parallel_sum(ThreadPool& pool, std::size_t n, std::size_t grain, T zero, Body&& body) {
  const std::size_t chunks = (n + grain - 1) / grain;
  std::vector<T> parts(chunks, zero);
  const auto one = [&](std::size_t c) {
    pool.before_chunk();
    parts[c] = body(c * grain, std::min(n, (c + 1) * grain));
  };
  if (chunks <= 1 || pool.threads() == 1) {
    for (std::size_t c = 0; c < chunks; ++c) one(c);
  } else {
    pool.run(chunks, one);
  }
  T sum = zero;
  for (const T& part : parts) sum += part;
  return sum;
}

/// std::sort; values that compare equal must be the same in every respect.
template <class T, class Less>
void parallel_sort(ThreadPool& pool, std::vector<T>& values, Less less) {
  constexpr std::size_t kGrain = 1 << 15;
  const auto at = [&](std::size_t i) {
    return values.begin() + static_cast<std::ptrdiff_t>(std::min(i, values.size()));
  };
  parallel_for(pool, values.size(), kGrain,
               [&](std::size_t begin, std::size_t end) { std::sort(at(begin), at(end), less); });
  for (std::size_t width = kGrain; width < values.size(); width *= 2)
    parallel_for(pool, values.size(), 2 * width, [&](std::size_t begin, std::size_t end) {
      std::inplace_merge(at(begin), at(begin + width), at(end), less);
    });
}

}  // namespace s3
