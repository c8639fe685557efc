#include "math/morton.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

using namespace s3;

TEST_CASE("the corners of a cube follow the Z of their coordinates") {
  Points corners(8, 3);
  for (int i = 0; i < 8; ++i) corners.row(7 - i) << (i & 1), (i >> 1 & 1), (i >> 2 & 1);
  CHECK(morton_order(corners) == std::vector<Index>{7, 6, 5, 4, 3, 2, 1, 0});
}

TEST_CASE("Morton order is a permutation, and brings neighbours together") {
  constexpr int n = 16;
  Points points(n * n * n, 3);
  for (int i = 0; i < points.rows(); ++i) {
    const int shuffled = (i * 1237) % (n * n * n);  // 1237 is odd: each number once
    points.row(i) << shuffled % n, shuffled / n % n, shuffled / n / n;
  }
  const std::vector<Index> order = morton_order(points);
  std::vector<Index> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<Index> all(order.size());
  std::iota(all.begin(), all.end(), 0);
  CHECK(sorted == all);
  double path = 0;
  for (std::size_t i = 1; i < order.size(); ++i)
    path += (points.row(order[i]) - points.row(order[i - 1])).norm();
  CHECK(path / static_cast<double>(order.size()) < 2);  // the shuffled order walks about 8 a step
}

TEST_CASE("equal points keep their order and an empty set is welcome") {
  CHECK(morton_order(Points(0, 3)).empty());
  CHECK(morton_order(Points::Constant(3, 3, 5.0)) == std::vector<Index>{0, 1, 2});
}
