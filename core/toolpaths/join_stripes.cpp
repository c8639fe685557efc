#include "toolpaths/join_stripes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "toolpaths/point_grid.h"

namespace s3 {
namespace {

constexpr double kOnFence = 0.5;       // of w
constexpr double kLongestJoint = 3.0;  // of w

/// A place on a closed path, by arc length from its first point.
struct FencePlace {
  Index fence = -1;
  double position = 0;
};

class Fences {
 public:
  Fences(const std::vector<Path>& paths, double width)
      : paths_(paths), reach_(kOnFence * width), grid_(reach_ + 0.25 * width) {
    for (std::size_t k = 0; k < paths.size(); ++k) {
      const Points& p = paths[k].points;
      std::vector<double> along = {0};
      for (Eigen::Index i = 0; i < p.rows(); ++i) {
        const Vec3 a = p.row(i), b = p.row((i + 1) % p.rows());
        const double length = (b - a).norm();
        const int parts = 1 + static_cast<int>(length / (0.25 * width));
        for (int j = 0; j < parts; ++j) {
          grid_.add(a + (b - a) * ((j + 0.5) / parts));
          owner_.push_back({static_cast<Index>(k), static_cast<Index>(i)});
        }
        along.push_back(along.back() + length);
      }
      along_.push_back(std::move(along));
    }
    grid_.finish();
  }

  double length(Index fence) const { return along_[static_cast<std::size_t>(fence)].back(); }

  FencePlace nearest(const Vec3& point) const {
    FencePlace best;
    double best_squared = reach_ * reach_;
    grid_.visit(point, [&](Index g) {
      const auto [k, i] = owner_[static_cast<std::size_t>(g)];
      const Points& p = paths_[static_cast<std::size_t>(k)].points;
      const Vec3 a = p.row(i), ab = Vec3(p.row((i + 1) % p.rows())) - a;
      const double length2 = ab.squaredNorm();
      const double t = length2 > 0 ? std::clamp((point - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
      const double squared = (point - a - t * ab).squaredNorm();
      if (squared >= best_squared) return;
      best_squared = squared;
      best = {k, along_[static_cast<std::size_t>(k)][static_cast<std::size_t>(i)] +
                     t * std::sqrt(length2)};
    });
    return best;
  }

  /// The way from one position to another in ascending direction.
  double gap(const FencePlace& from, const FencePlace& to) const {
    const double difference = to.position - from.position;
    return difference >= 0 ? difference : difference + length(from.fence);
  }

  /// The fence's points strictly between, in ascending direction.
  std::vector<Index> between(const FencePlace& from, const FencePlace& to) const {
    const auto& along = along_[static_cast<std::size_t>(from.fence)];
    const auto n = static_cast<Index>(along.size()) - 1;
    std::vector<Index> points;
    const double way = gap(from, to);
    auto i = static_cast<Index>(std::upper_bound(along.begin(), along.end(), from.position) -
                                along.begin());
    for (Index step = 0; step < n; ++step, ++i) {
      const FencePlace here{from.fence, along[static_cast<std::size_t>(i % n)]};
      if (gap(from, here) >= way) break;
      points.push_back(i % n);
    }
    return points;
  }

  const Path& path(Index fence) const { return paths_[static_cast<std::size_t>(fence)]; }

 private:
  const std::vector<Path>& paths_;
  double reach_;
  PointGrid grid_;
  std::vector<std::array<Index, 2>> owner_;  // fence and segment of each grid point
  std::vector<std::vector<double>> along_;   // #points+1 by fence
};

/// Grows a path point by point.
struct PathBuilder {
  std::vector<Vec3> points, normals;
  std::vector<double> thickness, width;

  void add(const Path& from, Eigen::Index i) {
    points.push_back(from.points.row(i));
    normals.push_back(from.normals.row(i));
    thickness.push_back(from.thickness(i));
    width.push_back(from.width(i));
  }
  Path finish(PathKind kind) const {
    Path path;
    const auto n = static_cast<Eigen::Index>(points.size());
    path.kind = kind;
    path.points.resize(n, 3);
    path.normals.resize(n, 3);
    path.thickness.resize(n);
    path.width.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      path.points.row(i) = points[k];
      path.normals.row(i) = normals[k];
      path.thickness(i) = thickness[k];
      path.width(i) = width[k];
    }
    return path;
  }
};

/// Ends are numbered 2·line and 2·line+1.
class Joiner {
 public:
  Joiner(const std::vector<Path>& lines, const std::vector<Path>& paths, double width)
      : lines_(lines), fences_(paths, width), longest_(kLongestJoint * width) {
    for (const Path& line : lines) {
      const bool open = !line.closed && line.points.rows() > 1;
      places_.push_back(open ? fences_.nearest(line.points.row(0)) : FencePlace{});
      places_.push_back(open ? fences_.nearest(line.points.row(line.points.rows() - 1))
                             : FencePlace{});
    }
    find_neighbors();
    used_.assign(lines.size(), 0);
  }

  std::vector<Path> join() {
    std::vector<Index> order(lines_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return partners(a) < partners(b); });
    std::vector<Path> result;
    for (const Index line : order) {
      if (used_[static_cast<std::size_t>(line)]) continue;
      used_[static_cast<std::size_t>(line)] = 1;
      if (lines_[static_cast<std::size_t>(line)].closed) {
        result.push_back(lines_[static_cast<std::size_t>(line)]);
        continue;
      }
      // Ends in the order of travel: in, out, in, out, …
      std::vector<Index> way = {2 * line, 2 * line + 1};
      extend(way);
      std::reverse(way.begin(), way.end());
      extend(way);
      result.push_back(build(way));
    }
    return result;
  }

 private:
  const FencePlace& place(Index end) const { return places_[static_cast<std::size_t>(end)]; }

  void find_neighbors() {
    std::vector<Index> order;
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (places_[i].fence >= 0) order.push_back(static_cast<Index>(i));
    std::sort(order.begin(), order.end(), [&](Index a, Index b) {
      return std::tuple(place(a).fence, place(a).position, a) <
             std::tuple(place(b).fence, place(b).position, b);
    });
    next_.assign(places_.size(), -1);
    previous_.assign(places_.size(), -1);
    for (std::size_t begin = 0; begin < order.size();) {
      std::size_t end = begin;
      while (end < order.size() && place(order[end]).fence == place(order[begin]).fence) ++end;
      for (std::size_t i = begin; i < end; ++i) {
        const Index a = order[i], b = order[i + 1 < end ? i + 1 : begin];
        if (a / 2 == b / 2 || fences_.gap(place(a), place(b)) > longest_) continue;
        next_[static_cast<std::size_t>(a)] = b;
        previous_[static_cast<std::size_t>(b)] = a;
      }
      begin = end;
    }
  }

  /// How many other lines this one could be joined with.
  std::size_t partners(Index line) const {
    std::vector<Index> others;
    for (const Index end : {2 * line, 2 * line + 1})
      for (const Index other :
           {next_[static_cast<std::size_t>(end)], previous_[static_cast<std::size_t>(end)]})
        if (other >= 0) others.push_back(other / 2);
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    return others.size();
  }

  void extend(std::vector<Index>& way) {
    while (true) {
      const Index end = way.back();
      Index best = -1;
      double shortest = std::numeric_limits<double>::infinity();
      for (const bool up : {true, false}) {
        const Index other = (up ? next_ : previous_)[static_cast<std::size_t>(end)];
        if (other < 0 || used_[static_cast<std::size_t>(other / 2)]) continue;
        const double gap =
            up ? fences_.gap(place(end), place(other)) : fences_.gap(place(other), place(end));
        if (gap < shortest) shortest = gap, best = other;
      }
      if (best < 0) return;
      used_[static_cast<std::size_t>(best / 2)] = 1;
      way.push_back(best);
      way.push_back(best ^ 1);
    }
  }

  Path build(const std::vector<Index>& way) const {
    PathBuilder path;
    for (std::size_t i = 0; i < way.size(); i += 2) {
      if (i > 0) add_joint(way[i - 1], way[i], path);
      const Path& line = lines_[static_cast<std::size_t>(way[i] / 2)];
      const Eigen::Index n = line.points.rows();
      for (Eigen::Index k = 0; k < n; ++k) path.add(line, way[i] % 2 == 0 ? k : n - 1 - k);
    }
    return path.finish(PathKind::infill);
  }

  void add_joint(Index from, Index to, PathBuilder& path) const {
    const bool up = next_[static_cast<std::size_t>(from)] == to &&
                    (previous_[static_cast<std::size_t>(from)] != to ||
                     fences_.gap(place(from), place(to)) <= fences_.gap(place(to), place(from)));
    std::vector<Index> points =
        up ? fences_.between(place(from), place(to)) : fences_.between(place(to), place(from));
    if (!up) std::reverse(points.begin(), points.end());
    for (const Index p : points) path.add(fences_.path(place(from).fence), p);
  }

  const std::vector<Path>& lines_;
  Fences fences_;
  double longest_;
  std::vector<FencePlace> places_;      // by end
  std::vector<Index> next_, previous_;  // by end: the neighbour on the fence, −1 for none
  std::vector<char> used_;              // by line
};

}  // namespace

std::vector<Path> join_stripes(const std::vector<Path>& lines, const std::vector<Path>& fences,
                               double width) {
  return Joiner(lines, fences, width).join();
}

}  // namespace s3
