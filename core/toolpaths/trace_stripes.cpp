// Crossings of an edge and a level are nodes. Within a triangle they are linked around its corners,
// as normal curves are: x_i = (n_ij + n_ik − n_jk)/2 links around corner i. Where the phase is
// linear that is its level set; where it is singular it still never crosses itself.
#include "toolpaths/trace_stripes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/units.h"

namespace s3 {
namespace {

class Tracer {
 public:
  Tracer(const StripeMesh& mesh, const StripePattern& pattern) : mesh_(mesh), pattern_(pattern) {
    place_nodes();
    link_nodes();
  }

  std::vector<StripeLine> lines() {
    std::vector<StripeLine> result;
    std::vector<char> seen(nodes_.size(), 0);
    for (const bool open : {true, false})
      for (std::size_t start = 0; start < nodes_.size(); ++start) {
        if (seen[start] || (open && links_[start][0].to >= 0 && links_[start][1].to >= 0)) continue;
        StripeLine line = follow(static_cast<Index>(start), seen);
        if (line.nodes.size() > 1) result.push_back(std::move(line));
      }
    return result;
  }

 private:
  struct Link {
    Index to = -1, triangle = -1;
  };

  void place_nodes() {
    const auto& ends = mesh_.edges.ends;
    first_.resize(ends.size() + 1);
    for (std::size_t e = 0; e < ends.size(); ++e) {
      first_[e] = static_cast<Index>(nodes_.size());
      const double from = pattern_.phase(ends[e][0]),
                   rise = pattern_.rise(static_cast<Eigen::Index>(e));
      // Levels (2k + 1)π between both ends.
      const double a = from / (2 * kPi) - 0.5, b = (from + rise) / (2 * kPi) - 0.5;
      const auto low = static_cast<int>(std::floor(std::min(a, b))) + 1,
                 high = static_cast<int>(std::floor(std::max(a, b)));
      for (int k = low; k <= high; ++k) {
        const int level = rise > 0 ? k : high + low - k;
        nodes_.push_back({static_cast<Index>(e), std::clamp((level - a) / (b - a), 0.0, 1.0)});
      }
    }
    first_.back() = static_cast<Index>(nodes_.size());
    links_.resize(nodes_.size());
  }

  /// Nodes of edge k of a triangle, from corner k to corner k+1.
  std::vector<Index> nodes_on(Eigen::Index f, std::size_t k) const {
    const auto e =
        static_cast<std::size_t>(mesh_.edges.of_triangle[static_cast<std::size_t>(f)][k]);
    std::vector<Index> nodes;
    for (Index n = first_[e]; n < first_[e + 1]; ++n) nodes.push_back(n);
    if (mesh_.edges.ends[e][0] != mesh_.triangles(f, static_cast<int>(k)))
      std::reverse(nodes.begin(), nodes.end());
    return nodes;
  }

  void link_nodes() {
    for (Eigen::Index f = 0; f < mesh_.triangles.rows(); ++f) {
      std::array<std::vector<Index>, 3> on;
      for (std::size_t k = 0; k < 3; ++k) on[k] = nodes_on(f, k);
      drop_ends(f, on);
      // Around corner k+1: the last nodes of edge k and the first of edge k+1.
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& before = on[k];
        const auto& after = on[(k + 1) % 3];
        const std::size_t count = (before.size() + after.size() - on[(k + 2) % 3].size()) / 2;
        for (std::size_t i = 0; i < count; ++i)
          link(before[before.size() - 1 - i], after[i], static_cast<Index>(f));
      }
    }
  }

  /// Takes the nodes at which lines end in a singular triangle out of the lists.
  void drop_ends(Eigen::Index f, std::array<std::vector<Index>, 3>& on) {
    auto& most = *std::max_element(
        on.begin(), on.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    std::size_t all = on[0].size() + on[1].size() + on[2].size();
    const auto drop_middle = [&] {
      const auto middle = most.begin() + static_cast<std::ptrdiff_t>(most.size() / 2);
      const Index node = *middle;
      most.erase(middle);
      --all;
      return node;
    };
    if (all % 2 == 1) drop_middle();
    while (2 * most.size() > all) {
      const Index a = drop_middle(), b = drop_middle();
      if (2 * most.size() == all && turns_around(f)) link(a, b, static_cast<Index>(f));
    }
  }

  /// Whether the line field has a singularity of half a turn in the triangle.
  bool turns_around(Eigen::Index f) const {
    int mirrors = 0;
    for (const Index e : mesh_.edges.of_triangle[static_cast<std::size_t>(f)])
      mirrors += pattern_.mirror[static_cast<std::size_t>(e)];
    return mirrors % 2 == 1;
  }

  void link(Index a, Index b, Index triangle) {
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
      const auto& beside = mesh_.edges.triangles[static_cast<std::size_t>(node(from).edge)];
      links_[static_cast<std::size_t>(from)][beside[0] == triangle ? 0 : 1] = {to, triangle};
    }
  }

  const StripeLine::Node& node(Index i) const { return nodes_[static_cast<std::size_t>(i)]; }

  StripeLine follow(Index start, std::vector<char>& seen) const {
    StripeLine line;
    const auto& first = links_[static_cast<std::size_t>(start)];
    Link way = first[0].to >= 0 ? first[0] : first[1];
    line.nodes.push_back(node(start));
    seen[static_cast<std::size_t>(start)] = 1;
    while (way.to >= 0) {
      line.triangles.push_back(way.triangle);
      if (way.to == start) {
        line.closed = true;
        break;
      }
      if (seen[static_cast<std::size_t>(way.to)]) {
        line.triangles.pop_back();
        break;
      }
      seen[static_cast<std::size_t>(way.to)] = 1;
      line.nodes.push_back(node(way.to));
      const auto& links = links_[static_cast<std::size_t>(way.to)];
      way = links[0].triangle == way.triangle ? links[1] : links[0];
    }
    return line;
  }

  const StripeMesh& mesh_;
  const StripePattern& pattern_;
  std::vector<StripeLine::Node> nodes_;
  std::vector<Index> first_;                // #E+1
  std::vector<std::array<Link, 2>> links_;  // through the edge's first and second triangle
};

}  // namespace

std::vector<StripeLine> trace_stripes(const StripeMesh& mesh, const StripePattern& pattern) {
  return Tracer(mesh, pattern).lines();
}

}  // namespace s3
