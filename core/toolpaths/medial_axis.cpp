#include "toolpaths/medial_axis.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <queue>
#include <utility>

#include "base/units.h"

namespace s3 {
namespace {

// Sides that open by less than 60° face each other: the axis between them is central.
constexpr double kCentralOpening = radians(120);
// Below this a branch of the axis is only a facet of a smooth boundary.
constexpr double kLeastOpening = radians(40);
// The bead count changes when the width is this much, in beads, away from the next rounding step:
// no flicker.
constexpr double kHysteresis = 0.15;
constexpr double kEvenEdge = 1.2;     // of w: WorkLayer::even
constexpr double kLongEdge = 0.8;     // of w: everywhere
constexpr double kShortEdge = 0.34;   // of w: near the medial axis
constexpr double kCentralBand = 0.8;  // of w: how far from a central piece "near" reaches
constexpr int kMaxRounds = 8;

struct Crossing {
  bool exists = false;
  double fraction = 0, radius = 0, opening = 0;
  std::array<BoundaryHit, 2> foot;
};

/// Whether the medial axis crosses an edge, by comparing each end's boundary piece with the
/// other's.
Crossing find_crossing(const WorkLayer& layer, Index e) {
  Crossing crossing;
  const auto [a, c] = layer.edges.ends[static_cast<std::size_t>(e)];
  const BoundarySource& source_a = layer.field.source[static_cast<std::size_t>(a)];
  const BoundarySource& source_c = layer.field.source[static_cast<std::size_t>(c)];
  if (source_a.edge < 0 || source_c.edge < 0 || source_a.edge == source_c.edge) return crossing;
  if (layer.edges.triangles[static_cast<std::size_t>(e)][1] < 0) return crossing;
  const Vec3 away_a = layer.field.away.row(a), away_c = layer.field.away.row(c);
  if (away_a.dot(away_c) > std::cos(0.5 * kLeastOpening)) return crossing;
  const Vec3 pa = layer.mesh.vertices.row(a), pc = layer.mesh.vertices.row(c);
  const Vec3 middle = 0.5 * (pa + pc);
  const BoundaryHit from_a = hit_boundary(layer.boundary, source_a, middle, false);
  const BoundaryHit from_c = hit_boundary(layer.boundary, source_c, middle, false);
  crossing.opening = std::acos(std::clamp(from_a.away.dot(from_c.away), -1.0, 1.0));
  if (crossing.opening < kLeastOpening) return crossing;
  // The two feet stay where they are, but for a few edges: on a round layer they would meet
  // otherwise.
  constexpr int kSlide = 3;
  BoundarySource near_a = source_a, near_c = source_c;
  near_a.edge = from_a.edge;
  near_c.edge = from_c.edge;
  const double excess_a =
      std::max(0.0, hit_boundary(layer.boundary, near_c, pa, false, kSlide).distance -
                        layer.field.distance(a));
  const double excess_c =
      std::max(0.0, hit_boundary(layer.boundary, near_a, pc, false, kSlide).distance -
                        layer.field.distance(c));
  if (excess_a + excess_c < 1e-3 * (pc - pa).norm()) return crossing;
  crossing.fraction = excess_a / (excess_a + excess_c);
  const Vec3 point = pa + crossing.fraction * (pc - pa);
  crossing.foot = {hit_boundary(layer.boundary, near_a, point, false, kSlide),
                   hit_boundary(layer.boundary, near_c, point, false, kSlide)};
  crossing.radius = 0.5 * (crossing.foot[0].distance + crossing.foot[1].distance);
  crossing.exists = true;
  return crossing;
}

std::vector<char> longer_edges(const WorkLayer& layer, double longest) {
  std::vector<char> split(layer.edges.ends.size(), 0);
  for (std::size_t e = 0; e < split.size(); ++e) {
    const auto [a, c] = layer.edges.ends[e];
    split[e] =
        (layer.mesh.vertices.row(a) - layer.mesh.vertices.row(c)).squaredNorm() > longest * longest;
  }
  return split;
}

std::vector<char> edges_to_split(const WorkLayer& layer, double width, const Context& ctx) {
  const auto n = static_cast<std::size_t>(layer.mesh.vertices.rows());
  std::vector<char> near(n, 0);
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  std::vector<double> reach(n, kCentralBand * width);
  for (Index e = 0; e < static_cast<Index>(layer.edges.ends.size()); ++e) {
    if (e % 4096 == 0) ctx.checkpoint();
    const Crossing crossing = find_crossing(layer, e);
    if (!crossing.exists) continue;
    for (const Index v : layer.edges.ends[static_cast<std::size_t>(e)]) {
      near[static_cast<std::size_t>(v)] = 1;
      if (crossing.opening < kCentralOpening - 0.2) continue;
      const double distance = std::max(0.0, crossing.radius - layer.field.distance(v));
      if (distance < reach[static_cast<std::size_t>(v)]) {
        reach[static_cast<std::size_t>(v)] = distance;
        front.emplace(distance, v);
      }
    }
  }
  // Grow the band around central pieces along the edges.
  const VertexGraph graph = make_vertex_graph(layer.edges.ends, static_cast<Index>(n));
  while (!front.empty()) {
    const auto [distance, a] = front.top();
    front.pop();
    if (distance > reach[static_cast<std::size_t>(a)]) continue;
    near[static_cast<std::size_t>(a)] = 1;
    for (auto i = graph.begin[static_cast<std::size_t>(a)];
         i < graph.begin[static_cast<std::size_t>(a) + 1]; ++i) {
      const Index c = graph.neighbor[static_cast<std::size_t>(i)];
      const double next =
          distance + (layer.mesh.vertices.row(c) - layer.mesh.vertices.row(a)).norm();
      if (next >= reach[static_cast<std::size_t>(c)]) continue;
      reach[static_cast<std::size_t>(c)] = next;
      front.emplace(next, c);
    }
  }
  std::vector<char> split(layer.edges.ends.size(), 0);
  for (std::size_t e = 0; e < split.size(); ++e) {
    const auto [a, c] = layer.edges.ends[e];
    const bool close = near[static_cast<std::size_t>(a)] || near[static_cast<std::size_t>(c)];
    const double longest = (close ? kShortEdge : kLongEdge) * width;
    split[e] =
        (layer.mesh.vertices.row(a) - layer.mesh.vertices.row(c)).squaredNorm() > longest * longest;
  }
  return split;
}

/// The source of a new vertex: the best of its edge's ends and the corners opposite.
void place_source(WorkLayer& layer, Index edge, const Triangles& triangles, Index vertex,
                  const Vec3& point, const Vec3& normal) {
  std::array<Index, 4> from = {layer.edges.ends[static_cast<std::size_t>(edge)][0],
                               layer.edges.ends[static_cast<std::size_t>(edge)][1], -1, -1};
  for (std::size_t side = 0; side < 2; ++side) {
    const Index f = layer.edges.triangles[static_cast<std::size_t>(edge)][side];
    if (f < 0) continue;
    for (int k = 0; k < 3; ++k)
      if (triangles(f, k) != from[0] && triangles(f, k) != from[1])
        from[2 + side] = triangles(f, k);
  }
  layer.field.distance(vertex) = std::numeric_limits<double>::infinity();
  for (const Index a : from) {
    if (a < 0 || layer.field.source[static_cast<std::size_t>(a)].edge < 0) continue;
    BoundarySource carried =
        carry_source(layer.field.source[static_cast<std::size_t>(a)], layer.mesh.vertices.row(a),
                     layer.mesh.normal.row(a), point, normal);
    const BoundaryHit hit = hit_boundary(layer.boundary, carried, point, true);
    if (!(hit.distance < layer.field.distance(vertex))) continue;
    carried.edge = hit.edge;
    layer.field.distance(vertex) = hit.distance;
    layer.field.away.row(vertex) = hit.away;
    layer.field.source[static_cast<std::size_t>(vertex)] = carried;
  }
}

/// Splits the marked edges in their middle and every triangle accordingly; no hanging vertices.
void split_edges(WorkLayer& layer, const std::vector<char>& split) {
  const Index old_count = static_cast<Index>(layer.mesh.vertices.rows());
  Index count = old_count;
  std::vector<Index> middle(split.size(), -1);
  for (std::size_t e = 0; e < split.size(); ++e)
    if (split[e]) middle[e] = count++;
  layer.mesh.vertices.conservativeResize(count, 3);
  layer.mesh.normal.conservativeResize(count, 3);
  layer.mesh.thickness.conservativeResize(count);
  layer.field.distance.conservativeResize(count);
  layer.field.away.conservativeResize(count, 3);
  layer.field.source.resize(static_cast<std::size_t>(count));
  for (std::size_t e = 0; e < split.size(); ++e) {
    const Index v = middle[e];
    if (v < 0) continue;
    const auto [a, c] = layer.edges.ends[e];
    const Vec3 point = 0.5 * (layer.mesh.vertices.row(a) + layer.mesh.vertices.row(c));
    Vec3 normal = layer.mesh.normal.row(a) + layer.mesh.normal.row(c);
    if (normal.squaredNorm() > 0) normal.normalize();
    layer.mesh.vertices.row(v) = point;
    layer.mesh.normal.row(v) = normal;
    layer.mesh.thickness(v) = 0.5 * (layer.mesh.thickness(a) + layer.mesh.thickness(c));
    layer.field.away.row(v).setZero();
    place_source(layer, static_cast<Index>(e), layer.mesh.triangles, v, point, normal);
    // The middle of a boundary edge lies on the boundary, whatever rounding says.
    if (layer.edges.triangles[e][1] < 0) {
      layer.field.distance(v) = 0;
      layer.field.away.row(v).setZero();
    }
  }
  std::vector<std::array<Index, 3>> result;
  std::vector<Index> origin;
  result.reserve(static_cast<std::size_t>(layer.mesh.triangles.rows()) * 2);
  for (Eigen::Index f = 0; f < layer.mesh.triangles.rows(); ++f) {
    std::array<Index, 3> v{}, m{};
    int cuts = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      v[k] = layer.mesh.triangles(f, static_cast<int>(k));
      m[k] =
          middle[static_cast<std::size_t>(layer.edges.of_triangle[static_cast<std::size_t>(f)][k])];
      cuts += m[k] >= 0;
    }
    if (cuts == 0) {
      result.push_back(v);
    } else if (cuts == 3) {
      for (std::size_t k = 0; k < 3; ++k) result.push_back({v[k], m[k], m[(k + 2) % 3]});
      result.push_back(m);
    } else if (cuts == 1) {
      const std::size_t k = m[0] >= 0 ? 0 : m[1] >= 0 ? 1 : 2;
      result.push_back({v[k], m[k], v[(k + 2) % 3]});
      result.push_back({m[k], v[(k + 1) % 3], v[(k + 2) % 3]});
    } else {
      // Two cuts: the corner between them, and the quad along its shorter diagonal.
      const std::size_t whole = m[0] < 0 ? 0 : m[1] < 0 ? 1 : 2;
      const Index a = v[whole], b = v[(whole + 1) % 3], c = v[(whole + 2) % 3];
      const Index bc = m[(whole + 1) % 3], ca = m[(whole + 2) % 3];
      result.push_back({bc, c, ca});
      const auto length2 = [&](Index p, Index q) {
        return (layer.mesh.vertices.row(p) - layer.mesh.vertices.row(q)).squaredNorm();
      };
      if (length2(a, bc) <= length2(b, ca)) {
        result.push_back({a, b, bc});
        result.push_back({a, bc, ca});
      } else {
        result.push_back({a, b, ca});
        result.push_back({b, bc, ca});
      }
    }
    origin.resize(result.size(), layer.origin[static_cast<std::size_t>(f)]);
  }
  layer.origin = std::move(origin);
  layer.mesh.triangles.resize(static_cast<Eigen::Index>(result.size()), 3);
  for (std::size_t f = 0; f < result.size(); ++f)
    for (int k = 0; k < 3; ++k)
      layer.mesh.triangles(static_cast<Eigen::Index>(f), k) =
          result[f][static_cast<std::size_t>(k)];
  layer.edges = make_edges(layer.mesh.triangles, count);
}

}  // namespace

WorkLayer prepare_layer(LayerMesh mesh, double width, const Context& ctx) {
  WorkLayer layer;
  layer.mesh = std::move(mesh);
  layer.edges = make_edges(layer.mesh.triangles, static_cast<Index>(layer.mesh.vertices.rows()));
  layer.boundary = make_boundary(layer.mesh, layer.edges);
  layer.field = boundary_distance(layer.mesh, layer.edges, layer.boundary, ctx);
  layer.origin.resize(static_cast<std::size_t>(layer.mesh.triangles.rows()));
  std::iota(layer.origin.begin(), layer.origin.end(), 0);
  for (int round = 0; round < kMaxRounds; ++round) {
    ctx.checkpoint();
    const std::vector<char> split = longer_edges(layer, kEvenEdge * width);
    if (std::find(split.begin(), split.end(), 1) == split.end()) break;
    split_edges(layer, split);
  }
  layer.even = {static_cast<Index>(layer.mesh.vertices.rows()), layer.mesh.triangles, layer.origin};
  for (int round = 0; round < kMaxRounds; ++round) {
    ctx.checkpoint();
    const std::vector<char> split = edges_to_split(layer, width, ctx);
    if (std::find(split.begin(), split.end(), 1) == split.end()) break;
    split_edges(layer, split);
  }
  return layer;
}

MedialPlan::MedialPlan(const WorkLayer& layer, double width, const Context& ctx) : width_(width) {
  find_nodes(layer, width, ctx);
  count_beads(width);
  place_inner_rings(width);
  samples_.resize(layer.boundary.loop_length.size());
  for (std::size_t i = 0; i < node_loop_.size(); ++i) {
    const MedialNode& node = axis_.nodes[i];
    for (std::size_t side = 0; side < 2; ++side)
      samples_[static_cast<std::size_t>(node_loop_[i][side])].push_back(
          {node_position_[i][side], node.radius, node.beads, node.central, node.shift});
  }
  for (auto& loop : samples_)
    std::sort(loop.begin(), loop.end(), [](const Sample& a, const Sample& b) {
      return std::pair(a.position, a.radius) < std::pair(b.position, b.radius);
    });
}

void MedialPlan::find_nodes(const WorkLayer& layer, double width, const Context& ctx) {
  std::vector<Index> node_of_edge(layer.edges.ends.size(), -1);
  for (Index e = 0; e < static_cast<Index>(layer.edges.ends.size()); ++e) {
    if (e % 4096 == 0) ctx.checkpoint();
    const Crossing crossing = find_crossing(layer, e);
    if (!crossing.exists || crossing.radius < 0.02 * width) continue;
    const auto [a, c] = layer.edges.ends[static_cast<std::size_t>(e)];
    const double t = crossing.fraction;
    MedialNode node;
    node.point = (1 - t) * layer.mesh.vertices.row(a) + t * layer.mesh.vertices.row(c);
    node.normal = ((1 - t) * layer.mesh.normal.row(a) + t * layer.mesh.normal.row(c)).normalized();
    node.thickness = (1 - t) * layer.mesh.thickness(a) + t * layer.mesh.thickness(c);
    node.radius = crossing.radius;
    node.opening = crossing.opening;
    node.central = crossing.opening >= kCentralOpening;
    node.vertex = layer.field.distance(a) > layer.field.distance(c) ? a : c;
    node_of_edge[static_cast<std::size_t>(e)] = static_cast<Index>(axis_.nodes.size());
    axis_.nodes.push_back(node);
    node_loop_.push_back({layer.boundary.loop[static_cast<std::size_t>(crossing.foot[0].edge)],
                          layer.boundary.loop[static_cast<std::size_t>(crossing.foot[1].edge)]});
    node_position_.push_back({crossing.foot[0].position, crossing.foot[1].position});
  }
  for (Eigen::Index f = 0; f < layer.mesh.triangles.rows(); ++f) {
    std::array<Index, 3> found{};
    std::size_t count = 0;
    for (const Index e : layer.edges.of_triangle[static_cast<std::size_t>(f)])
      if (node_of_edge[static_cast<std::size_t>(e)] >= 0)
        found[count++] = node_of_edge[static_cast<std::size_t>(e)];
    if (count == 2) axis_.links.push_back({found[0], found[1]});
    if (count < 3) continue;
    MedialNode middle = axis_.nodes[static_cast<std::size_t>(found[0])];
    middle.point.setZero();
    middle.normal.setZero();
    middle.thickness = middle.radius = 0;
    int central = 0;
    for (const Index i : found) {
      const MedialNode& node = axis_.nodes[static_cast<std::size_t>(i)];
      middle.point += node.point / 3;
      middle.normal += node.normal;
      middle.thickness += node.thickness / 3;
      middle.radius = std::max(middle.radius, node.radius);
      middle.opening = std::max(middle.opening, node.opening);
      central += node.central;
    }
    middle.normal.normalize();
    middle.central = central >= 2;
    const Index number = static_cast<Index>(axis_.nodes.size());
    axis_.nodes.push_back(middle);
    for (const Index i : found) axis_.links.push_back({i, number});
  }
  axis_.graph = make_vertex_graph(axis_.links, static_cast<Index>(axis_.nodes.size()));
}

void MedialPlan::count_beads(double width) {
  // Along connected central pieces the count changes only when it must.
  std::vector<char> seen(axis_.nodes.size(), 0);
  std::deque<Index> queue;
  const auto count = [&](double across, Index before) {
    if (across < kLeastBeadWidth) return Index{0};
    const auto nearest = std::max<Index>(1, static_cast<Index>(std::lround(across)));
    if (before > 0 && std::abs(across - static_cast<double>(before)) <= 0.5 + kHysteresis &&
        (before % 2 == 0 || across - static_cast<double>(before) + 1 >= kLeastBeadWidth))
      return before;
    return nearest;
  };
  for (std::size_t start = 0; start < axis_.nodes.size(); ++start) {
    if (seen[start] || !axis_.nodes[start].central) continue;
    seen[start] = 1;
    axis_.nodes[start].beads = count(2 * axis_.nodes[start].radius / width, 0);
    queue.push_back(static_cast<Index>(start));
    while (!queue.empty()) {
      const Index i = queue.front();
      queue.pop_front();
      const MedialNode& node = axis_.nodes[static_cast<std::size_t>(i)];
      for (auto k = axis_.graph.begin[static_cast<std::size_t>(i)];
           k < axis_.graph.begin[static_cast<std::size_t>(i) + 1]; ++k) {
        const Index j = axis_.graph.neighbor[static_cast<std::size_t>(k)];
        MedialNode& other = axis_.nodes[static_cast<std::size_t>(j)];
        if (seen[static_cast<std::size_t>(j)] || !other.central) continue;
        seen[static_cast<std::size_t>(j)] = 1;
        other.beads = count(2 * other.radius / width, node.beads);
        queue.push_back(j);
      }
    }
  }
}

void MedialPlan::place_inner_rings(double width) {
  // Of an even count, the innermost pair shares what is left; beside a single bead, rings keep
  // their place. Where one follows the other along the axis, a diffusion over about half a bead
  // makes the ring change over smoothly.
  constexpr int kRounds = 30;
  const auto pairs = [&](const MedialNode& node) { return node.central ? node.beads / 2 : 0; };
  for (MedialNode& node : axis_.nodes)
    if (pairs(node) > 0 && node.beads % 2 == 0)
      node.shift = 0.5 * (node.radius - pairs(node) * width);
  std::vector<double> next(axis_.nodes.size());
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < axis_.nodes.size(); ++i) {
      const MedialNode& node = axis_.nodes[i];
      double sum = node.shift;
      int count = 1;
      for (auto k = axis_.graph.begin[i]; k < axis_.graph.begin[i + 1]; ++k) {
        const MedialNode& other =
            axis_
                .nodes[static_cast<std::size_t>(axis_.graph.neighbor[static_cast<std::size_t>(k)])];
        if (pairs(other) == 0 || pairs(other) != pairs(node)) continue;
        sum += other.shift;
        ++count;
      }
      next[i] = sum / count;
    }
    for (std::size_t i = 0; i < axis_.nodes.size(); ++i) axis_.nodes[i].shift = next[i];
  }
}

BeadPlan MedialPlan::at(const BoundaryHit& hit, const LayerBoundary& boundary) const {
  BeadPlan plan;
  const auto loop_number =
      static_cast<std::size_t>(boundary.loop[static_cast<std::size_t>(hit.edge)]);
  const auto& loop = samples_[loop_number];
  const auto n = static_cast<std::ptrdiff_t>(loop.size());
  if (n == 0) return plan;
  const double length = boundary.loop_length[loop_number];
  const std::ptrdiff_t right =
      std::lower_bound(loop.begin(), loop.end(), hit.position,
                       [](const Sample& s, double p) { return s.position < p; }) -
      loop.begin();
  // The nearest sample on either side whose line reaches at least as far as this point.
  constexpr std::ptrdiff_t kMaxSearch = 256;
  const double least = hit.distance - 0.05 * width_;
  std::array<const Sample*, 2> side = {nullptr, nullptr};
  std::array<double, 2> gap{};
  for (const int s : {0, 1}) {
    for (std::ptrdiff_t step = 0; step < std::min(n, kMaxSearch); ++step) {
      std::ptrdiff_t i = s == 0 ? right - 1 - step : right + step;
      double shift = 0;
      if (i < 0) i += n, shift = -length;
      if (i >= n) i -= n, shift = length;
      const Sample& sample = loop[static_cast<std::size_t>(i)];
      if (sample.radius < least) continue;
      side[static_cast<std::size_t>(s)] = &sample;
      gap[static_cast<std::size_t>(s)] = std::abs(sample.position + shift - hit.position);
      break;
    }
  }
  if (!side[0] || !side[1]) return plan;
  const double sum = gap[0] + gap[1];
  const double t = sum > 0 ? gap[0] / sum : 0.5;
  const bool use_right = side[1]->central && (!side[0]->central || t > 0.5);
  plan.weight = (1 - t) * side[0]->central + t * side[1]->central;
  plan.beads = side[use_right ? 1 : 0]->beads;
  plan.shift = side[use_right ? 1 : 0]->shift;
  if (side[0]->central && side[1]->central && side[0]->beads / 2 == side[1]->beads / 2)
    plan.shift = (1 - t) * side[0]->shift + t * side[1]->shift;
  const bool both = side[0]->central && side[1]->central;
  plan.radius =
      both ? (1 - t) * side[0]->radius + t * side[1]->radius : side[use_right ? 1 : 0]->radius;
  if (!side[0]->central && !side[1]->central)
    plan.radius = std::max(side[0]->radius, side[1]->radius);
  return plan;
}

}  // namespace s3
