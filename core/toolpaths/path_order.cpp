#include "toolpaths/path_order.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace s3 {
namespace {

class Pieces {
 public:
  explicit Pieces(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  Index find(Index v) {
    while (parent_[static_cast<std::size_t>(v)] != v) {
      Index& p = parent_[static_cast<std::size_t>(v)];
      p = parent_[static_cast<std::size_t>(p)];
      v = p;
    }
    return v;
  }
  void join(Index a, Index b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<Index> parent_;
};

struct Nearest {
  double squared = std::numeric_limits<double>::infinity();
  Index point = 0;
};

Nearest nearest_start(const Path& path, const Vec3& place) {
  Nearest best;
  const Eigen::Index n = path.points.rows();
  const Eigen::Index step = path.closed ? 1 : std::max<Eigen::Index>(1, n - 1);
  for (Eigen::Index i = 0; i < n; i += step) {
    const double squared = (Vec3(path.points.row(i)) - place).squaredNorm();
    if (squared < best.squared) best = {squared, static_cast<Index>(i)};
  }
  return best;
}

Path start_at(const Path& path, Index first) {
  const Eigen::Index n = path.points.rows();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i)
    order[static_cast<std::size_t>(i)] =
        path.closed ? (first + i) % n : (first == 0 ? i : n - 1 - i);
  return path_through(path, order);
}

class Orderer {
 public:
  Orderer(const PathTree& tree, const Vec3& start) : tree_(tree), place_(start) {}

  void visit_all(std::vector<Index> groups) {
    while (!groups.empty()) {
      std::size_t best = 0;
      double squared = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < groups.size(); ++i)
        for (const Index p : tree_.groups[static_cast<std::size_t>(groups[i])].paths) {
          const double s = nearest_start(path(p), place_).squared;
          if (s < squared) squared = s, best = i;
        }
      const Index group = groups[best];
      groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(best));
      visit(group);
    }
  }

  std::vector<Path> result;

 private:
  const Path& path(Index p) const { return tree_.paths[static_cast<std::size_t>(p)].path; }

  void visit(Index number) {
    const PathGroup& group = tree_.groups[static_cast<std::size_t>(number)];
    std::vector<Index> left = group.paths;
    while (!left.empty()) {
      std::size_t best = 0;
      Nearest nearest;
      for (std::size_t i = 0; i < left.size(); ++i) {
        const Nearest n = nearest_start(path(left[i]), place_);
        if (n.squared < nearest.squared) nearest = n, best = i;
      }
      result.push_back(start_at(path(left[best]), nearest.point));
      const Path& last = result.back();
      place_ = last.points.row(last.closed ? 0 : last.points.rows() - 1);
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
    }
    visit_all(group.children);
  }

  const PathTree& tree_;
  Vec3 place_;
};

}  // namespace

PathTree nest_paths(const WorkLayer& layer, const Values& coordinate,
                    std::vector<PlannedPath> paths) {
  PathTree tree;
  const auto n = static_cast<std::size_t>(coordinate.size());
  std::vector<Index> by_height(n);
  std::iota(by_height.begin(), by_height.end(), 0);
  std::sort(by_height.begin(), by_height.end(), [&](Index a, Index b) {
    return std::pair(-coordinate(a), a) < std::pair(-coordinate(b), b);
  });
  const VertexGraph graph = make_vertex_graph(layer.edges.ends, static_cast<Index>(n));
  Index top = 0;
  for (const PlannedPath& p : paths) top = std::max(top, p.level);
  std::vector<std::vector<Index>> paths_at(static_cast<std::size_t>(top) + 1);
  for (std::size_t p = 0; p < paths.size(); ++p)
    paths_at[static_cast<std::size_t>(paths[p].level)].push_back(static_cast<Index>(p));

  Pieces pieces(n);
  std::vector<char> active(n, 0);
  std::vector<Index> group_of(n, -1);  // of a piece's first vertex, at the current level
  struct Open {
    Index group, vertex;
  };
  std::vector<Open> open;  // groups that wait for their parent
  std::size_t added = 0;
  for (Index level = top; level >= 0; --level) {
    for (; added < n && coordinate(by_height[added]) >= level + 0.5; ++added) {
      const Index v = by_height[added];
      active[static_cast<std::size_t>(v)] = 1;
      for (Index i = graph.begin[static_cast<std::size_t>(v)];
           i < graph.begin[static_cast<std::size_t>(v) + 1]; ++i) {
        const Index w = graph.neighbor[static_cast<std::size_t>(i)];
        if (active[static_cast<std::size_t>(w)]) pieces.join(v, w);
      }
    }
    std::vector<Open> current;
    std::vector<Index> touched;
    const auto group_at = [&](Index vertex) {
      const Index piece = pieces.find(vertex);
      Index& group = group_of[static_cast<std::size_t>(piece)];
      if (group < 0) {
        group = static_cast<Index>(tree.groups.size());
        tree.groups.push_back({level, {}, {}});
        current.push_back({group, vertex});
        touched.push_back(piece);
      }
      return group;
    };
    for (const Open& inner : open) {
      const Index parent = group_at(inner.vertex);
      tree.groups[static_cast<std::size_t>(parent)].children.push_back(inner.group);
    }
    for (const Index p : paths_at[static_cast<std::size_t>(level)]) {
      const Index vertex = paths[static_cast<std::size_t>(p)].inner_vertex;
      if (paths[static_cast<std::size_t>(p)].path.kind != PathKind::gap_fill) {
        const Index group = group_at(vertex);
        tree.groups[static_cast<std::size_t>(group)].paths.push_back(p);
      } else {
        // A single bead is a group of its own inside the ring around it.
        current.push_back({static_cast<Index>(tree.groups.size()), vertex});
        tree.groups.push_back({level, {p}, {}});
      }
    }
    open = std::move(current);
    for (const Index piece : touched) group_of[static_cast<std::size_t>(piece)] = -1;
  }
  for (const Open& outer : open) tree.roots.push_back(outer.group);
  tree.paths = std::move(paths);
  return tree;
}

std::vector<Path> order_paths(const PathTree& tree, const Vec3& start) {
  Orderer orderer(tree, start);
  orderer.visit_all(tree.roots);
  return std::move(orderer.result);
}

}  // namespace s3
