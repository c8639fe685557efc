#include "scalar_field/islands.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

namespace s3 {

namespace {

// Heights closer than this share of the whole count as equal: a flat underside is one island.
constexpr double kFlat = 1e-9;

// What has been printed and is connected.
struct Part {
  double begin = 0;   // G of its first vertex
  double volume = 0;  // mm³
  bool supported = false;
  std::vector<Index> minimum;  // vertices of the flat minimum that it grew from
};

// Vertices that share a tet, as one list for each vertex.
struct VertexGraph {
  std::vector<Index> begin, neighbor;
};

VertexGraph vertex_graph(const TetMesh& rest) {
  // An edge appears once for each tet around it; the repetitions cost less than finding them.
  VertexGraph graph;
  graph.begin.assign(static_cast<std::size_t>(rest.vertex_count()) + 1, 0);
  for (Index t = 0; t < rest.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) graph.begin[rest.tets(t, i) + 1] += 3;
  std::partial_sum(graph.begin.begin(), graph.begin.end(), graph.begin.begin());
  graph.neighbor.resize(static_cast<std::size_t>(graph.begin.back()));
  std::vector<Index> next(graph.begin.begin(), graph.begin.end() - 1);
  for (Index t = 0; t < rest.tet_count(); ++t)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        if (i != j) graph.neighbor[next[rest.tets(t, i)]++] = rest.tets(t, j);
  return graph;
}

// Visits every vertex that a way from the plate leads to, in the order in which rising water would
// come: reach(u, v, length) says at which level it comes to u from v.
template <class Reach>
void flood(const TetMesh& rest, const FieldOperators& operators, const ObjectiveField& objectives,
           const Values& value, double least_slope, Reach&& reach) {
  using Shore = std::pair<double, Index>;  // level, vertex: ties go by number
  std::priority_queue<Shore, std::vector<Shore>, std::greater<>> shore;
  std::vector<char> reached(objectives.vertex_on_plate);
  for (Index v = 0; v < rest.vertex_count(); ++v)
    if (reached[v]) shore.emplace(value(v), v);
  while (!shore.empty()) {
    const Index v = shore.top().second;
    shore.pop();
    operators.for_each_tet_around(v, [&](Index t) {
      for (int i = 0; i < 4; ++i) {
        const Index u = rest.tets(t, i);
        if (reached[u]) continue;
        const Vec3 edge = rest.vertices.row(u) - rest.vertices.row(v);
        const double length = edge.norm();
        if (edge.z() < least_slope * length) continue;
        reached[u] = 1;
        shore.emplace(reach(u, v, length), u);
      }
    });
  }
}

Vec3 centroid(const TetMesh& rest, const std::vector<Index>& vertices) {
  Vec3 sum = Vec3::Zero();
  for (const Index v : vertices) sum += rest.vertices.row(v).transpose();
  return sum / static_cast<double>(vertices.size());
}

}  // namespace

std::vector<Island> find_islands(const TetMesh& rest, const ObjectiveField& objectives,
                                 const Values& value) {
  const Index n = rest.vertex_count();
  Values vertex_volume = Values::Zero(n);  // a quarter of the tets around each vertex
  for (Index t = 0; t < rest.tet_count(); ++t)
    for (int i = 0; i < 4; ++i)
      vertex_volume(rest.tets(t, i)) += 0.25 * tet_volume(rest.vertices, rest.tets, t);
  const VertexGraph graph = vertex_graph(rest);
  const double flat = kFlat * (value.maxCoeff() - value.minCoeff());

  std::vector<Index> order;
  for (Index v = 0; v < n; ++v)
    if (graph.begin[v + 1] > graph.begin[v]) order.push_back(v);
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return value(a) != value(b) ? value(a) < value(b) : a < b; });

  std::vector<Index> parent(static_cast<std::size_t>(n), -1);  // −1: not printed yet
  const auto find = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<Part> part(static_cast<std::size_t>(n));  // of each root
  std::vector<Island> islands;
  // Joins the part at root b to that at root a; returns the root that stays.
  const auto join = [&](Index a, Index b, double level) {
    if (part[b].supported > part[a].supported ||
        (part[b].supported == part[a].supported && part[b].begin < part[a].begin))
      std::swap(a, b);
    // a is supported or older. Parts that began in one flat place are one; otherwise b was an
    // island until now.
    if (!part[b].supported) {
      if (level - part[b].begin > flat) {
        islands.push_back({centroid(rest, part[b].minimum), part[b].volume, level - part[b].begin});
      } else if (level - part[a].begin <= flat) {
        part[a].minimum.insert(part[a].minimum.end(), part[b].minimum.begin(),
                               part[b].minimum.end());
      }
    }
    part[a].volume += part[b].volume;
    part[b].minimum.clear();
    parent[b] = a;
    return a;
  };
  for (const Index v : order) {
    parent[v] = v;
    part[v] = {value(v), vertex_volume(v), objectives.vertex_on_plate[v] != 0, {v}};
    Index root = v;
    for (Index k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      const Index u = graph.neighbor[k];
      if (parent[u] < 0) continue;
      const Index other = find(u);
      if (other != root) root = join(root, other, value(v));
    }
  }
  for (const Index v : order)  // components that never meet the plate
    if (parent[v] == v && !part[v].supported)
      islands.push_back(
          {centroid(rest, part[v].minimum), part[v].volume, value(order.back()) - part[v].begin});
  return islands;
}

std::vector<std::vector<Index>> find_minima(const TetMesh& rest, const FieldOperators& operators,
                                            const ObjectiveField& objectives, const Values& value) {
  const double flat = kFlat * (value.maxCoeff() - value.minCoeff());
  // Vertices with something below them, or on the plate.
  std::vector<char> held(objectives.vertex_on_plate);
  for (Index t = 0; t < rest.tet_count(); ++t) {
    double lowest = value(rest.tets(t, 0));
    for (int i = 1; i < 4; ++i) lowest = std::min(lowest, value(rest.tets(t, i)));
    for (int i = 0; i < 4; ++i)
      if (value(rest.tets(t, i)) > lowest + flat) held[rest.tets(t, i)] = 1;
  }
  std::vector<std::vector<Index>> minima;
  std::vector<char> seen(held.size(), 0);
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    if (held[v] || seen[v] || !operators.in_use(v)) continue;
    // The flat place that v belongs to; it is held where one of its vertices is.
    std::vector<Index> place = {v};
    seen[v] = 1;
    bool supported = false;
    for (std::size_t k = 0; k < place.size(); ++k)
      operators.for_each_tet_around(place[k], [&](Index t) {
        for (int i = 0; i < 4; ++i) {
          const Index u = rest.tets(t, i);
          if (value(u) > value(place[k]) + flat) continue;
          supported = supported || held[u];
          if (!seen[u] && !held[u]) place.push_back(u);
          seen[u] = seen[u] || !held[u];
        }
      });
    if (supported) continue;
    std::sort(place.begin(), place.end());
    minima.push_back(std::move(place));
  }
  return minima;
}

Flood flood_from_plate(const TetMesh& rest, const FieldOperators& operators,
                       const ObjectiveField& objectives, const Values& value, double least_slope) {
  Flood result{std::vector<Index>(static_cast<std::size_t>(rest.vertex_count()), -1), value};
  flood(rest, operators, objectives, value, least_slope, [&](Index u, Index v, double) {
    result.from[u] = v;
    return result.level(u) = std::max(value(u), result.level(v));
  });
  return result;
}

Values drain_shallow_basins(const TetMesh& rest, const FieldOperators& operators,
                            const ObjectiveField& objectives, const Values& value, double depth,
                            double rise) {
  Values drained = value, pass = value;
  constexpr double kAnyWay = -2;
  flood(rest, operators, objectives, value, kAnyWay, [&](Index u, Index v, double length) {
    pass(u) = std::max(value(u), pass(v));
    if (pass(u) - value(u) <= depth) drained(u) = std::max(value(u), drained(v) + rise * length);
    return drained(u);
  });
  return drained;
}

}  // namespace s3
