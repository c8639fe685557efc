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

#ifdef __EMSCRIPTEN_PTHREADS__
// Calls the function, and returns false where a trap ended it: wasm/thread_guard.js.
extern "C" bool s3_survives(void (*function)(void*), void* argument);
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
  bool crashed = false;
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

  // False after a trap. WebAssembly cannot catch one, and nobody would tell the waiting caller.
  bool survives_work() {
#ifdef __EMSCRIPTEN_PTHREADS__
    return s3_survives([](void* state) { static_cast<State*>(state)->work(); }, this);
#else
    work();
    return true;
#endif
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
      const bool survived = survives_work();
      const std::lock_guard lock(mutex);
      if (!survived) crashed = true;
      if (--busy == 0 || crashed) idle.notify_one();
      if (crashed) return;
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
  s.idle.wait(lock, [&] { return s.busy == 0 || s.crashed; });
  if (s.crashed) __builtin_trap();  // memory may be damaged: the caller's thread ends, too
  if (s.failure) std::rethrow_exception(s.failure);
}

}  // namespace s3
