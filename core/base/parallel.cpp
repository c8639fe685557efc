#include "base/parallel.h"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace s3 {

#if defined(__EMSCRIPTEN__) && !defined(__EMSCRIPTEN_PTHREADS__)
#define S3_NO_THREADS 1
#endif

struct ThreadPool::State {
  int threads = 1;
  std::vector<std::thread> workers;
  std::mutex mutex;
  std::condition_variable wake, idle;
  const std::function<void(std::size_t)>* job = nullptr;
  std::size_t jobs = 0;
  std::atomic<std::size_t> next{0};
  int busy = 0;
  long generation = 0;
  bool stopping = false;
  std::exception_ptr failure;

  // Takes jobs until none is left; after a failure the remaining jobs are skipped.
  void work() {
    for (std::size_t i = next++; i < jobs; i = next++) {
      try {
        (*job)(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = jobs;
      }
    }
  }

  void worker_main() {
    long seen = 0;
    for (;;) {
      {
        std::unique_lock lock(mutex);
        wake.wait(lock, [&] { return stopping || generation != seen; });
        if (stopping) return;
        seen = generation;
      }
      work();
      const std::lock_guard lock(mutex);
      if (--busy == 0) idle.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads, std::function<void()> before_chunk)
    : state_(std::make_unique<State>()), before_chunk_(std::move(before_chunk)) {
#ifdef S3_NO_THREADS
  threads = 1;
#endif
  state_->threads = std::max(1, threads);
  for (int i = 1; i < state_->threads; ++i)
    state_->workers.emplace_back([state = state_.get()] { state->worker_main(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->wake.notify_all();
  for (auto& worker : state_->workers) worker.join();
}

int ThreadPool::threads() const {
  return state_->threads;
}

void ThreadPool::run(std::size_t jobs, const std::function<void(std::size_t)>& job) {
  State& s = *state_;
  if (s.threads == 1) {
    for (std::size_t i = 0; i < jobs; ++i) job(i);
    return;
  }
  {
    const std::lock_guard lock(s.mutex);
    s.job = &job;
    s.jobs = jobs;
    s.next = 0;
    s.failure = nullptr;
    s.busy = static_cast<int>(s.workers.size());
    ++s.generation;
  }
  s.wake.notify_all();
  s.work();
  std::unique_lock lock(s.mutex);
  s.idle.wait(lock, [&] { return s.busy == 0; });
  if (s.failure) std::rethrow_exception(s.failure);
}

}  // namespace s3
