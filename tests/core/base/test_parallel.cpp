#include <doctest/doctest.h>

#include <cmath>
#include <stdexcept>

#include "base/parallel.h"

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
