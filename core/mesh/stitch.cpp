#include "mesh/stitch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "mesh/aabb_tree.h"
#include "mesh/exact_predicates.h"
#include "mesh/surface_edges.h"
#include "mesh/weld.h"

namespace s3 {

namespace {

// Of the diagonal: from the rounding of single precision to the gaps that careless export leaves.
constexpr std::array<double, 4> kTolerances = {1e-6, 1e-5, 1e-4, 1e-3};
// Of the shortest edge at a vertex: what moves less cannot turn a triangle over or join two
// corners of one.
constexpr double kMove = 0.3;
constexpr int kMaxFlatRounds = 40;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

void drop_repeated(TriMesh& mesh) {
  std::vector<char> keep(at(static_cast<Index>(mesh.triangles.rows())));
  for (Index f = 0; f < mesh.triangles.rows(); ++f) keep[at(f)] = !has_repeated_corner(mesh, f);
  keep_triangles(mesh, keep);
}

void renumber(TriMesh& mesh, const std::vector<Index>& number) {
  for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i)
    mesh.triangles.data()[i] = number[at(mesh.triangles.data()[i])];
}

std::vector<Side> open_sides(const TriMesh& mesh) {
  const std::vector<Side> sides = sorted_sides(mesh);
  std::vector<Side> open;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin == 1) open.push_back(sides[begin]);
  });
  return open;
}

// Open edges, and twice those with too many triangles: joining must not trade one for the other.
std::size_t badness(const TriMesh& mesh) {
  std::size_t bad = 0;
  for_each_edge(sorted_sides(mesh), [&](std::size_t begin, std::size_t end) {
    if (end - begin != 2) bad += end - begin == 1 ? 1 : 2;
  });
  return bad;
}

std::vector<Index> vertices_of(const std::vector<Side>& sides) {
  std::vector<Index> vertices;
  for (const Side& side : sides) vertices.insert(vertices.end(), {side.low, side.high});
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

// #V: how far each vertex may move.
std::vector<double> reach_of_vertices(const TriMesh& mesh) {
  std::vector<double> reach(at(static_cast<Index>(mesh.vertices.rows())),
                            std::numeric_limits<double>::infinity());
  for (Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      const Index a = mesh.triangles(f, i), b = mesh.triangles(f, (i + 1) % 3);
      const double length = kMove * (mesh.vertices.row(a) - mesh.vertices.row(b)).norm();
      reach[at(a)] = std::min(reach[at(a)], length);
      reach[at(b)] = std::min(reach[at(b)], length);
    }
  return reach;
}

// A tree over points or segments, each a triangle without area.
AabbTree tree_of(const Points& points, const std::vector<std::array<Index, 2>>& segments) {
  Triangles triangles(static_cast<Eigen::Index>(segments.size()), 3);
  for (std::size_t i = 0; i < segments.size(); ++i)
    triangles.row(static_cast<Eigen::Index>(i)) << segments[i][0], segments[i][1], segments[i][1];
  return {points, triangles};
}

Box box_around(const Vec3& p, double reach) {
  return {p.array() - reach, p.array() + reach};
}

void join_open_vertices(TriMesh& mesh, double tolerance, Stitched& done) {
  const std::vector<Index> vertices = vertices_of(open_sides(mesh));
  const std::vector<double> reach = reach_of_vertices(mesh);
  std::vector<std::array<Index, 2>> points;
  points.reserve(vertices.size());
  for (const Index v : vertices) points.push_back({v, v});
  const AabbTree tree = tree_of(mesh.vertices, points);

  struct Pair {
    double distance;
    Index u, v;
    bool operator<(const Pair& o) const {
      if (distance != o.distance) return distance < o.distance;
      return u != o.u ? u < o.u : v < o.v;
    }
  };
  const auto allowed = [&](Index u, Index v) {
    return std::min({tolerance, reach[at(u)], reach[at(v)]});
  };
  std::vector<Pair> pairs;
  std::vector<Index> found;
  for (const Index u : vertices) {
    tree.triangles_in_box(box_around(mesh.vertices.row(u), std::min(tolerance, reach[at(u)])),
                          found);
    for (const Index i : found) {
      const Index v = vertices[at(i)];
      if (v <= u) continue;
      const double distance = (mesh.vertices.row(u) - mesh.vertices.row(v)).norm();
      if (distance <= allowed(u, v)) pairs.push_back({distance, u, v});
    }
  }
  std::sort(pairs.begin(), pairs.end());

  DisjointSets sets(at(static_cast<Index>(mesh.vertices.rows())));
  for (const Pair& pair : pairs) {
    const Index u = sets.find(pair.u), v = sets.find(pair.v);
    if (u == v) continue;
    const double distance = (mesh.vertices.row(u) - mesh.vertices.row(v)).norm();
    if (distance > std::min(allowed(u, v), allowed(pair.u, pair.v))) continue;
    sets.join(u, v);
    done.joined.add(mesh.vertices.row(pair.v));
    done.widest = std::max(done.widest, distance);
  }
  std::vector<Index> number(at(static_cast<Index>(mesh.vertices.rows())));
  for (std::size_t v = 0; v < number.size(); ++v) number[v] = sets.find(static_cast<Index>(v));
  renumber(mesh, number);
  drop_repeated(mesh);
}

// A vertex of one open edge that lies on another.
struct OnEdge {
  Index side;  // of the open ones
  double along;
  Index vertex;
  double distance;
  bool operator<(const OnEdge& o) const {
    if (side != o.side) return side < o.side;
    return along != o.along ? along < o.along : vertex < o.vertex;
  }
};

std::vector<OnEdge> vertices_on_edges(const TriMesh& mesh, const std::vector<Side>& open,
                                      double tolerance) {
  std::vector<std::array<Index, 2>> segments;
  segments.reserve(open.size());
  for (const Side& side : open) segments.push_back({side.from(), side.to()});
  const AabbTree tree = tree_of(mesh.vertices, segments);
  const std::vector<double> reach = reach_of_vertices(mesh);
  std::vector<OnEdge> all;
  std::vector<Index> found;
  for (const Index v : vertices_of(open)) {
    const double near = std::min(tolerance, reach[at(v)]);
    const Vec3 p = mesh.vertices.row(v);
    tree.triangles_in_box(box_around(p, near), found);
    for (const Index i : found) {
      const Side& side = open[at(i)];
      if (v == side.low || v == side.high || v == tip_of(mesh, side)) continue;
      const Vec3 a = mesh.vertices.row(side.from()), b = mesh.vertices.row(side.to());
      const double along = (p - a).dot(b - a) / (b - a).squaredNorm();
      const double distance = (a + along * (b - a) - p).norm();
      if (!(along > 0 && along < 1) || distance > near) continue;
      if (std::min((p - a).norm(), (p - b).norm()) <= distance) continue;  // nearer to an end
      all.push_back({i, along, v, distance});
    }
  }
  std::sort(all.begin(), all.end());
  return all;
}

// Of the vertices on an edge, those that an open edge joins with its ends or with each other: the
// others only pass by.
std::vector<OnEdge> those_of_seams(std::vector<OnEdge> all, const std::vector<Side>& open) {
  std::vector<std::array<Index, 2>> neighbours;
  for (const Side& side : open) {
    neighbours.push_back({side.low, side.high});
    neighbours.push_back({side.high, side.low});
  }
  std::sort(neighbours.begin(), neighbours.end());
  std::vector<OnEdge> kept;
  for (std::size_t begin = 0, end; begin < all.size(); begin = end) {
    for (end = begin; end < all.size() && all[end].side == all[begin].side;) ++end;
    const Side& side = open[at(all[begin].side)];
    const auto in_seam = [&](Index v) {
      if (v == side.low || v == side.high) return true;
      return std::any_of(all.begin() + static_cast<std::ptrdiff_t>(begin),
                         all.begin() + static_cast<std::ptrdiff_t>(end),
                         [&](const OnEdge& o) { return o.vertex == v; });
    };
    for (std::size_t i = begin; i < end; ++i) {
      const std::array<Index, 2> first = {all[i].vertex, -1};
      for (auto n = std::lower_bound(neighbours.begin(), neighbours.end(), first);
           n != neighbours.end() && (*n)[0] == all[i].vertex; ++n)
        if (in_seam((*n)[1])) {
          kept.push_back(all[i]);
          break;
        }
    }
  }
  return kept;
}

using Triangle = std::array<Index, 3>;

// Splits the one among `pieces` that has the side from→to at the given vertices of that side.
void split_piece(std::vector<Triangle>& pieces, Index from, Index to,
                 const std::vector<Index>& inserted) {
  if (inserted.empty()) return;
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i) {
      if (pieces[p][i] != from || pieces[p][(i + 1) % 3] != to) continue;
      const Index tip = pieces[p][(i + 2) % 3];
      pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(p));
      Index last = from;
      for (const Index v : inserted) {
        pieces.push_back({last, v, tip});
        last = v;
      }
      pieces.push_back({last, to, tip});
      return;
    }
}

void replace_triangles(TriMesh& mesh, const std::vector<char>& keep,
                       const std::vector<Triangle>& added) {
  keep_triangles(mesh, keep);
  const Eigen::Index kept = mesh.triangles.rows();
  mesh.triangles.conservativeResize(kept + static_cast<Eigen::Index>(added.size()), 3);
  for (std::size_t i = 0; i < added.size(); ++i)
    mesh.triangles.row(kept + static_cast<Eigen::Index>(i)) << added[i][0], added[i][1],
        added[i][2];
}

void split_at_vertices_on_edges(TriMesh& mesh, double tolerance, Stitched& done) {
  const std::vector<Side> open = open_sides(mesh);
  std::vector<OnEdge> hits = those_of_seams(vertices_on_edges(mesh, open, tolerance), open);
  if (hits.empty()) return;
  // By triangle and its side.
  std::sort(hits.begin(), hits.end(), [&](const OnEdge& a, const OnEdge& b) {
    const Index ca = open[at(a.side)].corner, cb = open[at(b.side)].corner;
    return ca != cb ? ca < cb : a < b;
  });
  std::vector<char> keep(at(static_cast<Index>(mesh.triangles.rows())), 1);
  std::vector<Triangle> added, pieces;
  std::vector<Index> inserted;
  for (std::size_t i = 0; i < hits.size();) {
    const Index f = open[at(hits[i].side)].triangle();
    keep[at(f)] = 0;
    pieces = {{mesh.triangles(f, 0), mesh.triangles(f, 1), mesh.triangles(f, 2)}};
    while (i < hits.size() && open[at(hits[i].side)].triangle() == f) {
      const Index side = hits[i].side;
      inserted.clear();
      for (; i < hits.size() && hits[i].side == side; ++i) {
        inserted.push_back(hits[i].vertex);
        done.split.add(mesh.vertices.row(hits[i].vertex));
        done.widest = std::max(done.widest, hits[i].distance);
      }
      split_piece(pieces, open[at(side)].from(), open[at(side)].to(), inserted);
    }
    added.insert(added.end(), pieces.begin(), pieces.end());
  }
  replace_triangles(mesh, keep, added);
  drop_repeated(mesh);
}

void append(Defect& to, const Defect& from) {
  for (const Vec3& place : from.where) to.add(place);
  to.count += from.count - static_cast<Index>(from.where.size());
}

}  // namespace

Defect weld_equal_vertices(TriMesh& mesh) {
  Defect joined;
  Welder welder(at(static_cast<Index>(mesh.vertices.rows())));
  std::vector<Index> number;
  number.reserve(at(static_cast<Index>(mesh.vertices.rows())));
  Index distinct = 0;
  for (Index v = 0; v < mesh.vertices.rows(); ++v) {
    number.push_back(welder.add(mesh.vertices.row(v)));
    if (number.back() == distinct)
      ++distinct;
    else
      joined.add(mesh.vertices.row(v));
  }
  if (joined.count == 0) return joined;
  mesh.vertices = welder.take();
  renumber(mesh, number);
  drop_repeated(mesh);
  return joined;
}

Stitched stitch_open_edges(TriMesh& mesh, const Context* ctx) {
  Stitched total;
  const double diagonal = bounding_box(mesh.vertices).diagonal();
  std::size_t bad = badness(mesh);
  for (const double tolerance : kTolerances) {
    if (open_sides(mesh).empty()) break;
    if (ctx) ctx->checkpoint();
    TriMesh trial = mesh;
    Stitched done;
    join_open_vertices(trial, tolerance * diagonal, done);
    split_at_vertices_on_edges(trial, tolerance * diagonal, done);
    const std::size_t left = badness(trial);
    if (left >= bad) continue;
    bad = left;
    mesh = std::move(trial);
    append(total.joined, done.joined);
    append(total.split, done.split);
    total.widest = std::max(total.widest, done.widest);
  }
  return total;
}

Defect collapse_short_edges(TriMesh& mesh, double length) {
  Defect collapsed;
  DisjointSets sets(at(static_cast<Index>(mesh.vertices.rows())));
  for_each_edge(sorted_sides(mesh), [&, sides = sorted_sides(mesh)](std::size_t begin,
                                                                    std::size_t) {
    const Index u = sets.find(sides[begin].low), v = sets.find(sides[begin].high);
    const auto distance = [&](Index i, Index j) {
      return (mesh.vertices.row(i) - mesh.vertices.row(j)).norm();
    };
    if (u == v || distance(sides[begin].low, sides[begin].high) > length || distance(u, v) > length)
      return;
    sets.join(u, v);
    collapsed.add(mesh.vertices.row(v));
  });
  if (collapsed.count == 0) return collapsed;
  std::vector<Index> number(at(static_cast<Index>(mesh.vertices.rows())));
  for (std::size_t v = 0; v < number.size(); ++v) number[v] = sets.find(static_cast<Index>(v));
  renumber(mesh, number);
  drop_repeated(mesh);
  return collapsed;
}

namespace {

// The side (as i: from corner i to corner i+1) that the opposite corner lies on, −1 for a triangle
// with a height.
int flat_side(const TriMesh& mesh, Index f, double height) {
  Corners c;
  for (int i = 0; i < 3; ++i) c[at(i)] = mesh.vertices.row(mesh.triangles(f, i));
  int longest = 0;
  double longest2 = -1;
  for (int i = 0; i < 3; ++i) {
    const double l2 = (c[at((i + 1) % 3)] - c[at(i)]).squaredNorm();
    if (l2 > longest2) longest = i, longest2 = l2;
  }
  const double area2 = (c[1] - c[0]).cross(c[2] - c[0]).norm();
  if (area2 > height * std::sqrt(longest2) && !is_degenerate(c)) return -1;
  return longest;
}

// One round: flat triangles that do not touch each other's neighbours.
// @return false when nothing was left to do
bool remove_flat_round(TriMesh& mesh, double height, Defect& removed) {
  std::vector<std::pair<Index, int>> flat;
  for (Index f = 0; f < mesh.triangles.rows(); ++f)
    if (const int side = flat_side(mesh, f, height); side >= 0) flat.emplace_back(f, side);
  if (flat.empty()) return false;
  const std::vector<Side> sides = sorted_sides(mesh);
  std::vector<char> touched(at(static_cast<Index>(mesh.triangles.rows())), 0);
  std::vector<char> keep(touched.size(), 1);
  std::vector<Triangle> added, pieces;
  for (const auto& [f, i] : flat) {
    const Index a = mesh.triangles(f, i), b = mesh.triangles(f, (i + 1) % 3),
                middle = mesh.triangles(f, (i + 2) % 3);
    Side key{std::min(a, b), std::max(a, b), 0, true};
    const auto begin = std::lower_bound(sides.begin(), sides.end(), key);
    auto end = begin;
    bool free = true;
    for (; end != sides.end() && end->same_edge(key); ++end)
      free = free && !touched[at(end->triangle())];
    if (!free) continue;
    for (auto side = begin; side != end; ++side) {
      const Index g = side->triangle();
      touched[at(g)] = 1;
      keep[at(g)] = 0;
      if (g == f || tip_of(mesh, *side) == middle) continue;
      pieces = {{mesh.triangles(g, 0), mesh.triangles(g, 1), mesh.triangles(g, 2)}};
      split_piece(pieces, side->from(), side->to(), {middle});
      added.insert(added.end(), pieces.begin(), pieces.end());
    }
    removed.add(mesh.vertices.row(middle));
  }
  replace_triangles(mesh, keep, added);
  return true;
}

}  // namespace

Defect remove_flat_triangles(TriMesh& mesh, double height) {
  Defect removed;
  drop_repeated(mesh);
  for (int round = 0; round < kMaxFlatRounds; ++round)
    if (!remove_flat_round(mesh, height, removed)) break;
  return removed;
}

}  // namespace s3
