#include "metrics/tube_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace s3 {
namespace {

double distance_to_axis(const Tube& tube, const Vec3& p) {
  const Vec3 along = tube.end - tube.begin;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp(along.dot(p - tube.begin) / length2, 0.0, 1.0) : 0.0;
  return (tube.begin + t * along - p).norm();
}

}  // namespace

int TubeGrid::coordinate(double value, int k) const {
  const double last = counts_[static_cast<std::size_t>(k)] - 1.0;
  return static_cast<int>(std::clamp(std::floor((value - low_(k)) / cell_), 0.0, last));
}

std::size_t TubeGrid::index(int i, int j, int k) const {
  return (static_cast<std::size_t>(k) * static_cast<std::size_t>(counts_[1]) +
          static_cast<std::size_t>(j)) *
             static_cast<std::size_t>(counts_[0]) +
         static_cast<std::size_t>(i);
}

template <class Body>
void TubeGrid::for_each_cell(Body&& body) const {
  for (std::size_t t = 0; t < tubes_.size(); ++t) {
    const Vec3 low = tubes_[t].begin.cwiseMin(tubes_[t].end);
    const Vec3 high = tubes_[t].begin.cwiseMax(tubes_[t].end);
    for (int k = coordinate(low.z(), 2); k <= coordinate(high.z(), 2); ++k)
      for (int j = coordinate(low.y(), 1); j <= coordinate(high.y(), 1); ++j)
        for (int i = coordinate(low.x(), 0); i <= coordinate(high.x(), 0); ++i)
          body(index(i, j, k), t);
  }
}

TubeGrid::TubeGrid(std::vector<Tube> tubes) : tubes_(std::move(tubes)) {
  low_ = high_ = tubes_.front().begin;
  double length = 0;
  for (const Tube& tube : tubes_) {
    low_ = low_.cwiseMin(tube.begin).cwiseMin(tube.end);
    high_ = high_.cwiseMax(tube.begin).cwiseMax(tube.end);
    largest_radius_ = std::max(largest_radius_, tube.radius);
    length += (tube.end - tube.begin).norm();
  }
  // Cells as large as a mean segment or bead, and never more cells than a few for each tube.
  const Vec3 size = (high_ - low_).cwiseMax(1e-6);
  const double count = static_cast<double>(tubes_.size());
  cell_ = std::max({length / count, 2 * largest_radius_, std::cbrt(size.prod() / (8 * count)),
                    size.maxCoeff() / 1024});
  for (int k = 0; k < 3; ++k)
    counts_[static_cast<std::size_t>(k)] = static_cast<int>(size(k) / cell_) + 1;

  begin_.assign(index(0, 0, counts_[2]) + 1, 0);
  for_each_cell([&](std::size_t cell, std::size_t) { ++begin_[cell + 1]; });
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  entries_.resize(begin_.back());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for_each_cell([&](std::size_t cell, std::size_t t) {
    entries_[next[cell]++] = static_cast<std::uint32_t>(t);
  });
}

double TubeGrid::signed_distance(const Vec3& p) const {
  const std::array<int, 3> centre = {coordinate(p.x(), 0), coordinate(p.y(), 1),
                                     coordinate(p.z(), 2)};
  const int last_ring = *std::max_element(counts_.begin(), counts_.end());
  double best = HUGE_VAL;
  for (int ring = 0; ring <= last_ring; ++ring) {
    // Everything in this ring is at least (ring − 1) cells away; p may lie outside the grid, which
    // only adds to that.
    if ((ring - 1) * cell_ - largest_radius_ > best) break;
    visit_ring(centre, ring, [&](const Tube& tube) {
      best = std::min(best, distance_to_axis(tube, p) - tube.radius);
    });
  }
  return best;
}

template <class Body>
void TubeGrid::visit_ring(const std::array<int, 3>& centre, int ring, Body&& body) const {
  const auto low = [&](std::size_t k) { return std::max(0, centre[k] - ring); };
  const auto high = [&](std::size_t k) { return std::min(counts_[k] - 1, centre[k] + ring); };
  for (int k = low(2); k <= high(2); ++k)
    for (int j = low(1); j <= high(1); ++j) {
      const bool on_side = std::abs(k - centre[2]) == ring || std::abs(j - centre[1]) == ring;
      const int step = on_side || ring == 0 ? 1 : 2 * ring;  // inner rows: both ends only
      for (int i = centre[0] - ring; i <= centre[0] + ring; i += step)
        if (i >= 0 && i < counts_[0]) visit_cell(index(i, j, k), body);
    }
}

template <class Body>
void TubeGrid::visit_cell(std::size_t cell, Body&& body) const {
  for (std::size_t e = begin_[cell]; e < begin_[cell + 1]; ++e) body(tubes_[entries_[e]]);
}

}  // namespace s3
