#include "mesh/fill_holes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "mesh/exact_predicates.h"
#include "mesh/fill_curved.h"
#include "mesh/fill_polygon.h"
#include "mesh/split_nonmanifold.h"
#include "mesh/surface_edges.h"

namespace s3 {

namespace {

constexpr double kFlat = 1e-3;  // a loop is flat when it leaves its plane by less, of its size
constexpr double kSamePlaneCosine = 1 - 1e-4;
constexpr double kLargestFairCap = 0.25;  // of the surface: how a larger cap bends is a guess

using Triangle = std::array<Index, 3>;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

// A closed walk along open edges, against the triangles behind them: a cap's triangles run along
// it.
struct Loop {
  std::vector<Index> vertices;
  std::vector<Index> behind;  // triangle behind vertices[i] → vertices[i+1]
  Vec3 area = Vec3::Zero();   // vector area, mm²
  Vec3 middle = Vec3::Zero();
  double size = 0;  // mm, diagonal of its box
  bool flat = false;

  Vec3 normal() const { return area.normalized(); }
};

void measure(const TriMesh& mesh, Loop& loop) {
  Box box{vertex_of(mesh, loop.vertices[0]), vertex_of(mesh, loop.vertices[0])};
  for (const Index v : loop.vertices) {
    loop.middle += vertex_of(mesh, v);
    box.min = box.min.cwiseMin(vertex_of(mesh, v));
    box.max = box.max.cwiseMax(vertex_of(mesh, v));
  }
  const std::size_t n = loop.vertices.size();
  loop.middle /= static_cast<double>(n);
  loop.size = box.diagonal();
  for (std::size_t i = 0; i < n; ++i)
    loop.area += 0.5 * (vertex_of(mesh, loop.vertices[i]) - loop.middle)
                           .cross(vertex_of(mesh, loop.vertices[(i + 1) % n]) - loop.middle);
  const Vec3 normal = loop.normal();
  double leaves = 0;
  for (const Index v : loop.vertices)
    leaves = std::max(leaves, std::abs(normal.dot(vertex_of(mesh, v) - loop.middle)));
  loop.flat = loop.area.norm() > 1e-12 * loop.size * loop.size && leaves <= kFlat * loop.size;
}

// Walks along open sides; a walk that comes back to a vertex it has seen is cut there, so that
// loops are simple.
std::vector<Loop> open_loops(const TriMesh& mesh, const std::vector<Side>& sides) {
  const std::vector<Index> partner = paired_sides(mesh, sides);
  struct Step {
    Index from, to, triangle;
    bool operator<(const Step& o) const {
      if (from != o.from) return from < o.from;
      return to != o.to ? to < o.to : triangle < o.triangle;
    }
  };
  std::vector<Step> steps;
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (partner[i] < 0) steps.push_back({sides[i].to(), sides[i].from(), sides[i].triangle()});
  std::sort(steps.begin(), steps.end());
  std::vector<std::size_t> next_of(at(static_cast<Index>(mesh.vertices.rows())) + 1, 0);
  for (const Step& step : steps) ++next_of[at(step.from) + 1];
  std::partial_sum(next_of.begin(), next_of.end(), next_of.begin());
  const std::vector<std::size_t> end_of(next_of.begin() + 1, next_of.end());

  std::vector<Loop> loops;
  std::vector<Index> place(end_of.size(), -1);  // of a vertex in the walk
  std::vector<std::size_t> walk;                // steps
  for (std::size_t start = 0; start < end_of.size(); ++start) {
    auto v = static_cast<Index>(start);
    for (;;) {
      if (place[at(v)] >= 0) {  // a loop closes
        Loop loop;
        const auto first = at(place[at(v)]);
        for (std::size_t i = first; i < walk.size(); ++i) {
          loop.vertices.push_back(steps[walk[i]].from);
          loop.behind.push_back(steps[walk[i]].triangle);
          place[at(steps[walk[i]].from)] = -1;
        }
        walk.resize(first);
        if (loop.vertices.size() >= 3) {
          measure(mesh, loop);
          loops.push_back(std::move(loop));
        }
      }
      if (next_of[at(v)] == end_of[at(v)]) {
        if (walk.empty()) break;
        // A dead end: edges that face the wrong way. What led here stays open.
        v = steps[walk.back()].from;
        walk.pop_back();
        place[at(v)] = -1;
        continue;
      }
      place[at(v)] = static_cast<Index>(walk.size());
      walk.push_back(next_of[at(v)]++);
      v = steps[walk.back()].to;
    }
  }
  return loops;
}

// Every flat loop with those it has inside it in its plane, facing the other way.
std::vector<std::vector<std::size_t>> flat_groups(const TriMesh& mesh,
                                                  const std::vector<Loop>& loops) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < loops.size(); ++i)
    if (loops[i].flat) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return loops[a].area.norm() < loops[b].area.norm();
  });
  const auto contains = [&](const Loop& outer, const Loop& inner) {
    const Vec3 n = outer.normal();
    if (inner.normal().dot(n) > -kSamePlaneCosine) return false;
    if (std::abs(n.dot(inner.middle - outer.middle)) > kFlat * outer.size) return false;
    int drop = 0;
    n.cwiseAbs().maxCoeff(&drop);
    const int i = (drop + 1) % 3, j = (drop + 2) % 3;
    const Vec3 p = vertex_of(mesh, inner.vertices[0]);
    bool inside = false;
    for (std::size_t k = 0; k < outer.vertices.size(); ++k) {
      const Vec3 a = vertex_of(mesh, outer.vertices[k]),
                 b = vertex_of(mesh, outer.vertices[(k + 1) % outer.vertices.size()]);
      if ((a[j] > p[j]) != (b[j] > p[j]) &&
          p[i] < a[i] + (p[j] - a[j]) / (b[j] - a[j]) * (b[i] - a[i]))
        inside = !inside;
    }
    return inside;
  };
  // The smallest loop around each one takes it, unless that has been taken itself.
  std::vector<std::vector<std::size_t>> inner(loops.size());
  std::vector<char> taken(loops.size(), 0);
  for (std::size_t a = order.size(); a-- > 0;) {  // the largest first
    if (taken[order[a]]) continue;
    for (std::size_t b = 0; b < a; ++b)
      if (!taken[order[b]] && contains(loops[order[a]], loops[order[b]])) {
        inner[order[a]].push_back(order[b]);
        taken[order[b]] = 1;
      }
  }
  std::vector<std::vector<std::size_t>> groups;
  for (const std::size_t i : order) {
    if (taken[i]) continue;
    groups.push_back({i});
    groups.back().insert(groups.back().end(), inner[i].begin(), inner[i].end());
  }
  return groups;
}

class Filler {
 public:
  Filler(TriMesh& mesh, bool fair, Context& ctx)
      : mesh_(mesh),
        fair_(fair),
        ctx_(ctx),
        sides_(sorted_sides(mesh)),
        fair_limit_(kLargestFairCap * surface_area(mesh)) {
    done_.first_new = static_cast<Index>(mesh.triangles.rows());
    for (Index v = 0; v < mesh.vertices.rows(); ++v) points_.push_back(vertex_of(mesh, v));
  }

  FilledHoles fill() {
    const std::vector<Loop> loops = open_loops(mesh_, sides_);
    if (loops.empty()) return done_;
    list_neighbours();
    std::vector<std::size_t> curved;
    for (const auto& group : flat_groups(mesh_, loops))
      if (!fill_flat(loops, group)) curved.insert(curved.end(), group.begin(), group.end());
    for (std::size_t i = 0; i < loops.size(); ++i)
      if (!loops[i].flat) curved.push_back(i);
    std::sort(curved.begin(), curved.end());
    for (const std::size_t i : curved) {
      ctx_.checkpoint();
      fill_curved_loop(loops[i]);
    }
    store();
    return done_;
  }

 private:
  void list_neighbours() {
    start_.assign(points_.size() + 1, 0);
    for_each_edge(sides_, [&](std::size_t begin, std::size_t) {
      ++start_[at(sides_[begin].low) + 1];
      ++start_[at(sides_[begin].high) + 1];
    });
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    neighbours_.resize(start_.back());
    std::vector<std::size_t> fill = start_;
    for_each_edge(sides_, [&](std::size_t begin, std::size_t) {
      neighbours_[fill[at(sides_[begin].low)]++] = sides_[begin].high;
      neighbours_[fill[at(sides_[begin].high)]++] = sides_[begin].low;
    });
  }

  bool is_edge(Index a, Index b) const {
    return std::any_of(neighbours_.begin() + static_cast<std::ptrdiff_t>(start_[at(a)]),
                       neighbours_.begin() + static_cast<std::ptrdiff_t>(start_[at(a) + 1]),
                       [b](Index v) { return v == b; });
  }

  void add(const std::vector<Triangle>& triangles) {
    for (const Triangle& t : triangles) {
      added_.push_back(t);
      done_.area += 0.5 * (points_[at(t[1])] - points_[at(t[0])])
                              .cross(points_[at(t[2])] - points_[at(t[0])])
                              .norm();
    }
  }

  // A chord of the cap that the mesh has already would be an edge of four triangles.
  bool uses_old_edge(const std::vector<Triangle>& triangles, const Loop& loop) const {
    std::vector<std::array<Index, 2>> rim;
    for (std::size_t i = 0; i < loop.vertices.size(); ++i)
      rim.push_back({loop.vertices[i], loop.vertices[(i + 1) % loop.vertices.size()]});
    std::sort(rim.begin(), rim.end());
    for (const Triangle& t : triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        const Index a = t[i], b = t[(i + 1) % 3];
        if (!std::binary_search(rim.begin(), rim.end(), std::array<Index, 2>{a, b}) &&
            !std::binary_search(rim.begin(), rim.end(), std::array<Index, 2>{b, a}) &&
            is_edge(a, b))
          return true;
      }
    return false;
  }

  bool fill_flat(const std::vector<Loop>& loops, const std::vector<std::size_t>& group) {
    std::vector<std::vector<Index>> outline;
    outline.reserve(group.size());
    for (const std::size_t i : group) outline.push_back(loops[i].vertices);
    const auto triangles = fill_polygon(mesh_.vertices, outline, loops[group[0]].normal());
    if (triangles.empty() || (group.size() == 1 && uses_old_edge(triangles, loops[group[0]])))
      return false;
    add(triangles);
    for (const std::size_t i : group) {
      done_.flat.add(loops[i].middle);
      done_.largest = std::max(done_.largest, loops[i].size);
    }
    return true;
  }

  void fill_curved_loop(const Loop& loop) {
    HoleRim rim;
    rim.loop = loop.vertices;
    std::vector<Index> sorted = loop.vertices;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
      const Index v = loop.vertices[i];
      rim.outward.push_back(
          triangle_normal_2a(mesh_.vertices, mesh_.triangles.row(loop.behind[i])).normalized());
      rim.neighbours.emplace_back(
          neighbours_.begin() + static_cast<std::ptrdiff_t>(start_[at(v)]),
          neighbours_.begin() + static_cast<std::ptrdiff_t>(start_[at(v) + 1]));
      for (const Index u : rim.neighbours.back())
        if (v < u && std::binary_search(sorted.begin(), sorted.end(), u))
          rim.edges.push_back({v, u});
    }
    std::sort(rim.edges.begin(), rim.edges.end());
    const bool fair = fair_ && loop.area.norm() < fair_limit_;
    CurvedFill cap =
        s3::fill_curved(mesh_.vertices, rim, static_cast<Index>(points_.size()), fair, ctx_);
    if (cap.triangles.empty()) {
      done_.left_open.add(loop.middle);
      done_.area += loop.area.norm();
      done_.largest = std::max(done_.largest, loop.size);
      return;
    }
    points_.insert(points_.end(), cap.points.begin(), cap.points.end());
    add(cap.triangles);
    done_.curved.add(loop.middle);
    done_.largest = std::max(done_.largest, loop.size);
  }

  void store() {
    const Eigen::Index old_vertices = mesh_.vertices.rows(), old_triangles = mesh_.triangles.rows();
    mesh_.vertices.conservativeResize(static_cast<Eigen::Index>(points_.size()), 3);
    for (auto v = static_cast<std::size_t>(old_vertices); v < points_.size(); ++v)
      mesh_.vertices.row(static_cast<Eigen::Index>(v)) = points_[v];
    mesh_.triangles.conservativeResize(old_triangles + static_cast<Eigen::Index>(added_.size()), 3);
    for (std::size_t f = 0; f < added_.size(); ++f)
      mesh_.triangles.row(old_triangles + static_cast<Eigen::Index>(f)) << added_[f][0],
          added_[f][1], added_[f][2];
  }

  TriMesh& mesh_;
  bool fair_;
  Context& ctx_;
  std::vector<Side> sides_;
  double fair_limit_;
  std::vector<std::size_t> start_;  // of a vertex's neighbours
  std::vector<Index> neighbours_;
  std::vector<Vec3> points_;
  std::vector<Triangle> added_;
  FilledHoles done_;
};

}  // namespace

FilledHoles fill_holes(TriMesh& mesh, bool fair, Context& ctx) {
  return Filler(mesh, fair, ctx).fill();
}

}  // namespace s3
