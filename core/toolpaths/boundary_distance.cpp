// Distance by propagation of unfolded boundary edges; see the header. The idea of carrying the
// nearest feature instead of a number is Danielsson's vector distance transform (1980), here on a
// triangle mesh with the normals' rotation.
#include "toolpaths/boundary_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace s3 {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A convex turn above this separates two sides of a medial axis; below, it is a facet of a smooth
// curve.
constexpr double kCornerTurn = 0.35;  // rad, 20°

struct EdgeHit {
  double squared = kInfinity;
  double fraction = 0;
  Vec3 difference = Vec3::Zero();  // point − nearest point, in the boundary's frame
};

EdgeHit hit_edge(const LayerBoundary& boundary, Index e, const Vec3& p) {
  const Vec3& a = boundary.from[static_cast<std::size_t>(e)];
  const Vec3 ab = boundary.to[static_cast<std::size_t>(e)] - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  EdgeHit hit;
  hit.fraction = t;
  hit.difference = p - (a + t * ab);
  hit.squared = hit.difference.squaredNorm();
  return hit;
}

double loop_position(const LayerBoundary& boundary, Index e, const EdgeHit& hit) {
  const auto i = static_cast<std::size_t>(e);
  const Vec3 ab = boundary.to[i] - boundary.from[i];
  const double length = ab.norm();
  double position = boundary.position[i] + hit.fraction * length;
  if (length == 0 || (hit.fraction > 0 && hit.fraction < 1)) return position;
  // In the fan of a reflex corner: by the angle from the edge's own normal.
  const double along = hit.difference.dot(ab) / length;
  const double across = std::sqrt(std::max(0.0, hit.squared - along * along));
  const double angle = std::atan2(std::abs(along), across);
  if (hit.fraction >= 1)
    position += boundary.fan_scale * std::min(angle, std::max(0.0, -boundary.turn[i]));
  else
    position -=
        boundary.fan_scale *
        std::min(angle,
                 std::max(0.0, -boundary.turn[static_cast<std::size_t>(boundary.previous[i])]));
  return position;
}

/// The least rotation that takes unit vector a to b.
Mat3 rotation_between(const Vec3& a, const Vec3& b) {
  const Vec3 v = a.cross(b);
  const double c = std::max(a.dot(b), -0.999);
  Mat3 cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return c * Mat3::Identity() + cross + v * v.transpose() / (1 + c);
}

void chain_loops(LayerBoundary& boundary, const std::vector<Index>& to_vertex,
                 const std::vector<Vec3>& end_normal) {
  const auto n = static_cast<std::size_t>(boundary.size());
  // Edges by start vertex; where loops touch in a vertex, successors are handed out in order.
  std::vector<Index> by_start(n);
  for (std::size_t i = 0; i < n; ++i) by_start[i] = static_cast<Index>(i);
  const auto start = [&](Index e) { return boundary.from_vertex[static_cast<std::size_t>(e)]; };
  std::sort(by_start.begin(), by_start.end(),
            [&](Index a, Index b) { return std::pair(start(a), a) < std::pair(start(b), b); });
  std::vector<char> taken(n, 0);
  boundary.next.assign(n, -1);
  boundary.previous.assign(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const auto first = std::lower_bound(by_start.begin(), by_start.end(), to_vertex[i],
                                        [&](Index e, Index v) { return start(e) < v; });
    for (auto it = first; it != by_start.end() && start(*it) == to_vertex[i]; ++it) {
      if (taken[static_cast<std::size_t>(*it)]) continue;
      taken[static_cast<std::size_t>(*it)] = 1;
      boundary.next[i] = *it;
      boundary.previous[static_cast<std::size_t>(*it)] = static_cast<Index>(i);
      break;
    }
  }
  // A surface that is not a manifold may leave chains open: they then end in themselves.
  for (std::size_t i = 0; i < n; ++i) {
    if (boundary.next[i] < 0) boundary.next[i] = static_cast<Index>(i);
    if (boundary.previous[i] < 0) boundary.previous[i] = static_cast<Index>(i);
  }
  boundary.turn.assign(n, 0);
  double total = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto j = static_cast<std::size_t>(boundary.next[i]);
    const Vec3 a = boundary.to[i] - boundary.from[i], b = boundary.to[j] - boundary.from[j];
    total += a.norm();
    boundary.turn[i] = std::atan2(a.cross(b).dot(end_normal[i]), a.dot(b));
  }
  boundary.fan_scale = n > 0 ? total / static_cast<double>(n) : 1;
  boundary.loop.assign(n, -1);
  boundary.position.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (boundary.loop[i] >= 0) continue;
    const auto loop = static_cast<Index>(boundary.loop_length.size());
    double position = 0;
    for (auto e = i; boundary.loop[e] < 0; e = static_cast<std::size_t>(boundary.next[e])) {
      boundary.loop[e] = loop;
      boundary.position[e] = position;
      position += (boundary.to[e] - boundary.from[e]).norm() +
                  boundary.fan_scale * std::max(0.0, -boundary.turn[e]);
    }
    boundary.loop_length.push_back(position);
  }
}

}  // namespace

double longest_edge(const LayerMesh& layer) {
  double longest = 0;
  for (Eigen::Index f = 0; f < layer.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, (layer.vertices.row(layer.triangles(f, k)) -
                                   layer.vertices.row(layer.triangles(f, (k + 1) % 3)))
                                      .norm());
  return longest;
}

EdgeTable make_edges(const Triangles& triangles, Index vertices) {
  struct HalfEdge {
    Index high, corner;
  };
  const Eigen::Index faces = triangles.rows();
  std::vector<Index> begin(static_cast<std::size_t>(vertices) + 1, 0);
  for (Eigen::Index f = 0; f < faces; ++f)
    for (int k = 0; k < 3; ++k)
      ++begin[static_cast<std::size_t>(std::min(triangles(f, k), triangles(f, (k + 1) % 3))) + 1];
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<HalfEdge> halves(static_cast<std::size_t>(faces) * 3);
  std::vector<Index> fill(begin.begin(), begin.end() - 1);
  for (Eigen::Index f = 0; f < faces; ++f)
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles(f, k), b = triangles(f, (k + 1) % 3);
      halves[static_cast<std::size_t>(fill[static_cast<std::size_t>(std::min(a, b))]++)] = {
          std::max(a, b), static_cast<Index>(3 * f + k)};
    }
  EdgeTable table;
  table.of_triangle.resize(static_cast<std::size_t>(faces));
  for (Index low = 0; low < vertices; ++low) {
    const auto first = halves.begin() + begin[static_cast<std::size_t>(low)],
               last = halves.begin() + begin[static_cast<std::size_t>(low) + 1];
    std::sort(first, last, [](const HalfEdge& a, const HalfEdge& b) {
      return std::pair(a.high, a.corner) < std::pair(b.high, b.corner);
    });
    for (auto h = first; h != last; ++h) {
      if (h == first || h->high != (h - 1)->high) {
        table.ends.push_back({low, h->high});
        table.triangles.push_back({-1, -1});
      }
      auto& beside = table.triangles.back();
      beside[beside[0] < 0 ? 0 : 1] = h->corner / 3;
      table.of_triangle[static_cast<std::size_t>(h->corner / 3)]
                       [static_cast<std::size_t>(h->corner % 3)] =
          static_cast<Index>(table.ends.size()) - 1;
    }
  }
  return table;
}

VertexGraph make_vertex_graph(const std::vector<std::array<Index, 2>>& links, Index vertices) {
  VertexGraph graph;
  graph.begin.assign(static_cast<std::size_t>(vertices) + 1, 0);
  graph.neighbor.resize(links.size() * 2);
  for (const auto& link : links)
    for (const Index v : link) ++graph.begin[static_cast<std::size_t>(v) + 1];
  for (std::size_t v = 1; v < graph.begin.size(); ++v) graph.begin[v] += graph.begin[v - 1];
  std::vector<Index> fill(graph.begin.begin(), graph.begin.end() - 1);
  for (const auto& link : links) {
    graph.neighbor[static_cast<std::size_t>(fill[static_cast<std::size_t>(link[0])]++)] = link[1];
    graph.neighbor[static_cast<std::size_t>(fill[static_cast<std::size_t>(link[1])]++)] = link[0];
  }
  return graph;
}

LayerBoundary make_boundary(const LayerMesh& mesh, const EdgeTable& edges) {
  LayerBoundary boundary;
  std::vector<Index> to_vertex;
  std::vector<Vec3> end_normal;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Index e = edges.of_triangle[static_cast<std::size_t>(f)][static_cast<std::size_t>(k)];
      if (edges.triangles[static_cast<std::size_t>(e)][1] >= 0) continue;
      const Index a = mesh.triangles(f, k), b = mesh.triangles(f, (k + 1) % 3);
      boundary.from.push_back(mesh.vertices.row(a));
      boundary.to.push_back(mesh.vertices.row(b));
      boundary.from_vertex.push_back(a);
      to_vertex.push_back(b);
      end_normal.push_back(mesh.normal.row(b));
    }
  chain_loops(boundary, to_vertex, end_normal);
  return boundary;
}

BoundaryHit hit_boundary(const LayerBoundary& boundary, const BoundarySource& source,
                         const Vec3& point, bool cross_corners, int slide) {
  const Vec3 p = source.turn * point + source.shift;
  Index edge = source.edge;
  EdgeHit best = hit_edge(boundary, edge, p);
  for (const bool forward : {true, false}) {
    for (int step = 0; step < slide; ++step) {
      // Only the end at which the nearest point sits can lead to something nearer, or a corner that
      // turns towards p.
      const auto i = static_cast<std::size_t>(edge);
      const Index other = forward ? boundary.next[i] : boundary.previous[i];
      if (other == edge) break;
      const double turn = boundary.turn[static_cast<std::size_t>(forward ? edge : other)];
      if (!cross_corners && turn > kCornerTurn) break;
      const EdgeHit hit = hit_edge(boundary, other, p);
      if (!(hit.squared < best.squared)) break;
      best = hit;
      edge = other;
    }
  }
  BoundaryHit result;
  result.distance = std::sqrt(best.squared);
  result.edge = edge;
  result.position = loop_position(boundary, edge, best);
  if (result.distance > 0)
    result.away = source.turn.transpose() * (best.difference / result.distance);
  return result;
}

BoundarySource carry_source(const BoundarySource& source, const Vec3& from, const Vec3& from_normal,
                            const Vec3& to, const Vec3& to_normal) {
  // The two tangent planes meet about half way.
  const Vec3 hinge = 0.5 * (from + to);
  const Mat3 back = rotation_between(to_normal, from_normal);
  BoundarySource carried;
  carried.edge = source.edge;
  carried.turn = source.turn * back;
  carried.shift = source.turn * (hinge - back * hinge) + source.shift;
  return carried;
}

BoundaryDistance boundary_distance(const LayerMesh& mesh, const EdgeTable& edges,
                                   const LayerBoundary& boundary, const Context& ctx) {
  const auto n = static_cast<std::size_t>(mesh.vertices.rows());
  BoundaryDistance result;
  result.distance.setConstant(mesh.vertices.rows(), kInfinity);
  result.away.setZero(mesh.vertices.rows(), 3);
  result.source.resize(n);

  const VertexGraph graph = make_vertex_graph(edges.ends, static_cast<Index>(n));
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  for (Index e = 0; e < boundary.size(); ++e) {
    const Index v = boundary.from_vertex[static_cast<std::size_t>(e)];
    result.distance(v) = 0;
    result.source[static_cast<std::size_t>(v)].edge = e;
    front.emplace(0.0, v);
  }
  std::vector<char> done(n, 0);
  for (std::size_t popped = 0; !front.empty(); ++popped) {
    if (popped % 4096 == 0) ctx.checkpoint();
    const Index a = front.top().second;
    front.pop();
    if (done[static_cast<std::size_t>(a)]) continue;
    done[static_cast<std::size_t>(a)] = 1;
    const BoundarySource& source = result.source[static_cast<std::size_t>(a)];
    for (auto i = graph.begin[static_cast<std::size_t>(a)];
         i < graph.begin[static_cast<std::size_t>(a) + 1]; ++i) {
      const Index c = graph.neighbor[static_cast<std::size_t>(i)];
      if (done[static_cast<std::size_t>(c)]) continue;
      BoundarySource carried = carry_source(source, mesh.vertices.row(a), mesh.normal.row(a),
                                            mesh.vertices.row(c), mesh.normal.row(c));
      const BoundaryHit hit = hit_boundary(boundary, carried, mesh.vertices.row(c), true);
      if (!(hit.distance < result.distance(c))) continue;
      carried.edge = hit.edge;
      result.distance(c) = hit.distance;
      result.away.row(c) = hit.away;
      result.source[static_cast<std::size_t>(c)] = carried;
      front.emplace(hit.distance, c);
    }
  }
  return result;
}

}  // namespace s3
