#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "metrics/print_metrics.h"

namespace s3 {
namespace {

struct Tube {
  Vec3 begin, end;
  double radius;
};

/// One tube for each way that extrudes: round, with the area width × height of the bead, around its
/// centre line.
std::vector<Tube> make_tubes(const Waypoints& w) {
  const auto centre = [&](Index i, double height) -> Vec3 {
    return w.position.row(i) - height / 2 * w.normal.row(i);
  };
  std::vector<Tube> tubes;
  for (Index i = 1; i < w.size(); ++i) {
    if (w.travel[static_cast<std::size_t>(i)]) continue;
    const double height = w.height(i);
    tubes.push_back(
        {centre(i - 1, height), centre(i, height), std::sqrt(w.width(i) * height / kPi)});
  }
  return tubes;
}

double distance_to_axis(const Tube& tube, const Vec3& p) {
  const Vec3 along = tube.end - tube.begin;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp(along.dot(p - tube.begin) / length2, 0.0, 1.0) : 0.0;
  return (tube.begin + t * along - p).norm();
}

/// Tubes by the cells of a grid that their axes' boxes touch.
class TubeGrid {
 public:
  explicit TubeGrid(std::vector<Tube> tubes) : tubes_(std::move(tubes)) {
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
    for (int k = 0; k < 3; ++k) counts_[k] = static_cast<int>(size(k) / cell_) + 1;
    fill();
  }

  /// |distance to the nearest tube's axis − radius|, the nearest tube being that of the least
  /// distance − radius.
  double surface_distance(const Vec3& p) const {
    double best = HUGE_VAL;
    const Vec3 at = (p - low_) / cell_;
    int centre[3];
    for (int k = 0; k < 3; ++k)
      centre[k] = static_cast<int>(std::clamp(std::floor(at(k)), 0.0, counts_[k] - 1.0));
    const int last_ring = std::max({counts_[0], counts_[1], counts_[2]});
    for (int ring = 0; ring <= last_ring; ++ring) {
      // Everything in this ring is at least (ring − 1) cells away; p may lie outside the grid,
      // which only adds to that.
      if ((ring - 1) * cell_ - largest_radius_ > best) break;
      visit_ring(centre, ring, [&](const Tube& tube) {
        best = std::min(best, distance_to_axis(tube, p) - tube.radius);
      });
    }
    return std::abs(best);
  }

 private:
  int coordinate(double value, int k) const {
    return static_cast<int>(std::clamp((value - low_(k)) / cell_, 0.0, counts_[k] - 1.0));
  }
  std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * counts_[1] + j) * counts_[0] + i;
  }

  template <class Body>
  void for_each_cell(Body&& body) const {
    for (std::size_t t = 0; t < tubes_.size(); ++t) {
      const Vec3 low = tubes_[t].begin.cwiseMin(tubes_[t].end),
                 high = tubes_[t].begin.cwiseMax(tubes_[t].end);
      for (int k = coordinate(low.z(), 2); k <= coordinate(high.z(), 2); ++k)
        for (int j = coordinate(low.y(), 1); j <= coordinate(high.y(), 1); ++j)
          for (int i = coordinate(low.x(), 0); i <= coordinate(high.x(), 0); ++i)
            body(index(i, j, k), t);
    }
  }

  void fill() {
    begin_.assign(static_cast<std::size_t>(counts_[0]) * counts_[1] * counts_[2] + 1, 0);
    for_each_cell([&](std::size_t cell, std::size_t) { ++begin_[cell + 1]; });
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    entries_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for_each_cell([&](std::size_t cell, std::size_t t) {
      entries_[next[cell]++] = static_cast<std::uint32_t>(t);
    });
  }

  template <class Body>
  void visit_ring(const int (&centre)[3], int ring, Body&& body) const {
    const auto low = [&](int k) { return std::max(0, centre[k] - ring); };
    const auto high = [&](int k) { return std::min(counts_[k] - 1, centre[k] + ring); };
    for (int k = low(2); k <= high(2); ++k)
      for (int j = low(1); j <= high(1); ++j) {
        const bool on_side = std::abs(k - centre[2]) == ring || std::abs(j - centre[1]) == ring;
        const int step = on_side || ring == 0 ? 1 : 2 * ring;  // inner rows: both ends only
        for (int i = centre[0] - ring; i <= centre[0] + ring; i += step)
          if (i >= 0 && i < counts_[0]) visit_cell(index(i, j, k), body);
      }
  }

  template <class Body>
  void visit_cell(std::size_t cell, Body&& body) const {
    for (std::size_t e = begin_[cell]; e < begin_[cell + 1]; ++e) body(tubes_[entries_[e]]);
  }

  std::vector<Tube> tubes_;
  Vec3 low_, high_;
  double largest_radius_ = 0;
  double cell_ = 1;
  int counts_[3] = {1, 1, 1};
  std::vector<std::size_t> begin_;
  std::vector<std::uint32_t> entries_;
};

/// Points spread evenly over the surface, a fixed number in all: each triangle gets its share of
/// the area, placed by a low-discrepancy sequence. No random numbers, so that every print of a
/// model is measured at the same places.
Points sample_surface(const TriMesh& surface, double samples) {
  const double spacing_area = surface_area(surface) / samples;
  std::vector<Vec3> points;
  double due = 0.5;  // samples owed: carries the remainders from triangle to triangle
  double u = 0.5, v = 0.5;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corner = [&](int k) -> Vec3 {
      return surface.vertices.row(surface.triangles(f, k));
    };
    due += triangle_normal_2a(surface.vertices, surface.triangles.row(f)).norm() / 2 / spacing_area;
    for (; due >= 1; due -= 1) {
      u = std::fmod(u + 0.7548776662466927, 1.0);  // the R2 sequence (M. Roberts 2018)
      v = std::fmod(v + 0.5698402909980532, 1.0);
      const double a = u + v > 1 ? 1 - u : u, b = u + v > 1 ? 1 - v : v;
      points.push_back((1 - a - b) * corner(0) + a * corner(1) + b * corner(2));
    }
  }
  Points rows(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = points[i];
  return rows;
}

}  // namespace

void surface_error(const TriMesh& surface, const Waypoints& waypoints, Metrics& metrics,
                   Context& ctx) {
  std::vector<Tube> tubes = make_tubes(waypoints);
  if (tubes.empty() || surface.triangles.rows() == 0) return;
  const TubeGrid grid(std::move(tubes));
  constexpr double kSamples = 100000;
  const Points samples = sample_surface(surface, kSamples);
  Values error(samples.rows());
  constexpr std::size_t kGrain = 2048;
  parallel_for(ctx.pool, static_cast<std::size_t>(samples.rows()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 ctx.checkpoint();
                 for (std::size_t i = begin; i < end; ++i) {
                   const auto row = static_cast<Eigen::Index>(i);
                   error(row) = grid.surface_distance(samples.row(row));
                 }
               });
  if (error.size() == 0) return;
  metrics.surface_error_avg_mm = error.mean();
  metrics.surface_error_max_mm = error.maxCoeff();
}

}  // namespace s3
