#include "base/parallel.h"

#include <atomic>
#include <cmath>
#include <functional>
#include <stdexcept>

#include <doctest/doctest.h>

#include "base/context.h"

using namespace s3;

TEST_CASE("a parallel sum does not depend on the number of threads") {
  const auto sum = [](int threads) {
    ThreadPool pool(threads);
    return parallel_sum(pool, 100003, 1000, 0.0, [](std::size_t begin, std::size_t end) {
      double s = 0;
      for (std::size_t i = begin; i < end; ++i) s += std::sin(static_cast<double>(i));
      return s;
    });
  };
  const double one = sum(1);
  CHECK(sum(2) == one);
  CHECK(sum(5) == one);
}

TEST_CASE("an exception in a chunk reaches the caller and the pool stays usable") {
  ThreadPool pool(3);
  CHECK_THROWS_AS(parallel_for(pool, 100, 1,
                               [](std::size_t b, std::size_t) {
                                 if (b == 42) throw std::runtime_error("x");
                               }),
                  std::runtime_error);
  std::vector<int> hit(100, 0);
  parallel_for(pool, 100, 7, [&](std::size_t b, std::size_t e) {
    for (auto i = b; i < e; ++i) ++hit[i];
  });
  for (int h : hit) CHECK(h == 1);
}

TEST_CASE("a parallel sort sorts, whatever the number of threads and values") {
  for (const std::size_t count : {0, 1, 1000, 32768, 32769, 200000}) {
    std::vector<double> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = std::sin(static_cast<double>(i));
    std::vector<double> expected = values;
    std::sort(expected.begin(), expected.end());
    for (const int threads : {1, 3}) {
      ThreadPool pool(threads);
      std::vector<double> sorted = values;
      parallel_sort(pool, sorted, std::less<>());
      CHECK(sorted == expected);
    }
  }
}

TEST_CASE("a cancel ends a loop over chunks, of one thread or several") {
  for (const int threads : {1, 3}) {
    Context ctx(threads);
    std::atomic<int> done{0};
    const auto loop = [&] {
      parallel_for(ctx.pool, 1000, 1, [&](std::size_t, std::size_t) {
        if (++done == 10) ctx.cancel_requested = true;
      });
    };
    CHECK_THROWS_AS(loop(), Cancelled);
    CHECK(done >= 10);
    CHECK(done < 20);  // each thread ends the chunk that it is at
    ctx.cancel_requested = false;
    done = 10;
    loop();
    CHECK(done == 1010);
  }
}
