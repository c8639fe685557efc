// Isotropic remeshing by local operations: M. Botsch, L. Kobbelt, "A Remeshing Approach to
// Multiresolution Modeling", SGP 2004; flips make the triangulation intrinsically Delaunay instead
// of equalising valences.
#include "layers/remesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mesh/aabb_tree.h"

namespace s3 {
namespace {

constexpr int kIterations = 3;
// New triangles keep this cosine to the ones they replace.
constexpr double kMinNormalCosine = 0.5;
// A triangle is too thin to be made on purpose when its height falls below this share of its
// longest edge.
constexpr double kMinHeightRatio = 0.02;

constexpr int next(int i) {
  return i == 2 ? 0 : i + 1;
}
constexpr int previous(int i) {
  return i == 0 ? 2 : i - 1;
}

class Remesher {
 public:
  Remesher(const Isosurface& raw, const RemeshTarget& target, Context& ctx)
      : raw_(raw), target_(target), ctx_(ctx), tree_(raw.surface) {
    load();
  }

  Isosurface run() {
    const double longest = 4.0 / 3.0 * target_.edge_length,
                 shortest = 4.0 / 5.0 * target_.edge_length;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      ctx_.checkpoint();
      collapse_short_edges(shortest, longest);
      ctx_.checkpoint();
      split_long_edges(longest);
      ctx_.checkpoint();
      flip_edges();
      ctx_.checkpoint();
      relax();
    }
    ctx_.checkpoint();
    collapse_short_edges(0.5 * shortest, longest);
    flip_edges();
    return result();
  }

 private:
  // A triangle (a, b, c) has the edge opposite corner i between corners i+1 and i+2; neighbour −1
  // is the boundary.
  void load();
  void match_neighbors();
  void split_pinched_vertices();

  bool alive(Index f) const { return tri_[f][0] >= 0; }
  int corner_of(Index f, Index v) const { return tri_[f][0] == v ? 0 : tri_[f][1] == v ? 1 : 2; }
  // The corner of g opposite the edge that runs from `from` to `to` in g.
  int opposite_corner(Index g, Index from, Index to) const {
    for (int j = 0; j < 2; ++j)
      if (tri_[g][next(j)] == from && tri_[g][previous(j)] == to) return j;
    return 2;
  }
  void point_to(Index g, Index from, Index to, Index f) {
    if (g >= 0) neighbor_[g][opposite_corner(g, from, to)] = f;
  }
  Vec3 normal_2a(const Vec3& a, const Vec3& b, const Vec3& c) const { return (b - a).cross(c - a); }
  Vec3 normal_2a(Index f) const {
    return normal_2a(point_[tri_[f][0]], point_[tri_[f][1]], point_[tri_[f][2]]);
  }

  void collect_ring(Index v);
  bool may_replace(Index f, int corner, const Vec3& position) const;
  void collapse_short_edges(double shortest, double longest);
  bool try_collapse(Index f, int i, double longest);
  bool collapse(Index f, int i, double longest);
  void split_long_edges(double longest);
  void split(Index f, int i);
  void flip_edges();
  bool flip_if_better(Index f, int i);
  void relax();
  Isosurface result();

  const Isosurface& raw_;
  RemeshTarget target_;
  Context& ctx_;
  AabbTree tree_;
  std::vector<Vec3> point_;
  std::vector<std::array<Index, 3>> tri_, neighbor_;
  std::vector<Index> face_of_;  // a triangle of each vertex; −1 when the vertex is gone
  std::vector<char> on_boundary_;
  std::vector<double> boundary_error_;  // mm: how far the boundary may have moved near the vertex
  std::vector<Index> ring_;  // triangles around a vertex, counter-clockwise (collect_ring)
  std::vector<Index> ring_vertices_;
  std::vector<Index> other_vertices_;
};

void Remesher::load() {
  const auto n = static_cast<std::size_t>(raw_.surface.vertices.rows());
  const auto m = static_cast<std::size_t>(raw_.surface.triangles.rows());
  point_.resize(n);
  for (std::size_t v = 0; v < n; ++v)
    point_[v] = raw_.surface.vertices.row(static_cast<Eigen::Index>(v)).transpose();
  tri_.resize(m);
  for (std::size_t f = 0; f < m; ++f)
    for (int i = 0; i < 3; ++i)
      tri_[f][i] = raw_.surface.triangles(static_cast<Eigen::Index>(f), i);
  match_neighbors();
  split_pinched_vertices();
  face_of_.assign(point_.size(), -1);
  on_boundary_.assign(point_.size(), 0);
  boundary_error_.assign(point_.size(), 0);
  for (std::size_t f = 0; f < m; ++f)
    for (int i = 0; i < 3; ++i) {
      face_of_[tri_[f][i]] = static_cast<Index>(f);
      if (neighbor_[f][i] < 0)
        on_boundary_[tri_[f][next(i)]] = on_boundary_[tri_[f][previous(i)]] = 1;
    }
}

void Remesher::match_neighbors() {
  neighbor_.assign(tri_.size(), {-1, -1, -1});
  std::vector<Index> head(point_.size(), -1),
      link(tri_.size() * 3, -1);  // half-edges by their smaller vertex
  for (Index h = 0; h < static_cast<Index>(link.size()); ++h) {
    const Index f = h / 3;
    const int i = h % 3;
    const Index from = tri_[f][next(i)], to = tri_[f][previous(i)], low = std::min(from, to);
    for (Index k = head[low]; k >= 0; k = link[k]) {
      const Index g = k / 3;
      const int j = k % 3;
      if (tri_[g][next(j)] == to && tri_[g][previous(j)] == from && neighbor_[g][j] < 0) {
        neighbor_[g][j] = f;
        neighbor_[f][i] = g;
        break;
      }
    }
    link[h] = head[low];
    head[low] = h;
  }
}

// Gives each fan of triangles around a vertex its own copy of it.
void Remesher::split_pinched_vertices() {
  std::vector<char> claimed(point_.size(), 0), visited(tri_.size() * 3, 0);
  std::vector<std::pair<Index, int>> fan;
  for (Index f = 0; f < static_cast<Index>(tri_.size()); ++f)
    for (int i = 0; i < 3; ++i) {
      if (visited[f * 3 + i]) continue;
      const Index v = tri_[f][i];
      fan.clear();
      for (const bool forward : {true, false}) {
        Index g = f;
        int c = i;
        for (;;) {
          if (!visited[g * 3 + c]) {
            visited[g * 3 + c] = 1;
            fan.emplace_back(g, c);
          }
          g = neighbor_[g][forward ? next(c) : previous(c)];
          if (g < 0) break;
          c = corner_of(g, v);
          if (visited[g * 3 + c]) break;
        }
      }
      if (!claimed[v]) {
        claimed[v] = 1;
        continue;
      }
      const Index copy = static_cast<Index>(point_.size());
      const Vec3 position = point_[v];
      point_.push_back(position);
      claimed.push_back(1);
      for (const auto& [g, c] : fan) tri_[g][c] = copy;
    }
}

// Fills ring_ and ring_vertices_: the neighbours of v, in order; for a boundary vertex the first
// and the last lie on the boundary and there is one vertex more than triangles.
void Remesher::collect_ring(Index v) {
  ring_.clear();
  ring_vertices_.clear();
  Index f = face_of_[v];
  const Index start = f;
  for (;;) {  // back to the boundary, or once around
    const Index g = neighbor_[f][previous(corner_of(f, v))];
    if (g < 0) break;
    f = g;
    if (f == start) break;
  }
  const Index first = f;
  for (;;) {
    const int c = corner_of(f, v);
    ring_.push_back(f);
    ring_vertices_.push_back(tri_[f][next(c)]);
    const Index g = neighbor_[f][next(c)];
    if (g < 0) {
      ring_vertices_.push_back(tri_[f][previous(c)]);
      break;
    }
    f = g;
    if (f == first) break;
  }
}

// Whether triangle f keeps its orientation and a sensible shape when a corner moves to `position`.
bool Remesher::may_replace(Index f, int corner, const Vec3& position) const {
  const Vec3 &b = point_[tri_[f][next(corner)]], &c = point_[tri_[f][previous(corner)]];
  const Vec3 old_normal = normal_2a(f), new_normal = normal_2a(position, b, c);
  const double longest =
      std::max({(b - c).squaredNorm(), (position - b).squaredNorm(), (position - c).squaredNorm()});
  const double length = new_normal.norm();
  if (length < kMinHeightRatio * longest) return false;
  const double old_length = old_normal.norm();
  // A triangle without area has no orientation to keep.
  if (old_length < 1e-6 * longest) return true;
  return new_normal.dot(old_normal) >= kMinNormalCosine * length * old_length;
}

void Remesher::collapse_short_edges(double shortest, double longest) {
  const double limit = shortest * shortest;
  for (Index f = 0; f < static_cast<Index>(tri_.size()); ++f) {
    if (!alive(f)) continue;
    // The shortest edge first: it is what makes the triangle a sliver.
    std::array<std::pair<double, int>, 3> edges;
    for (int i = 0; i < 3; ++i)
      edges[i] = {(point_[tri_[f][next(i)]] - point_[tri_[f][previous(i)]]).squaredNorm(), i};
    std::sort(edges.begin(), edges.end());
    for (const auto& [squared, i] : edges) {
      if (squared >= limit) break;
      if (try_collapse(f, i, longest)) break;
    }
  }
}

bool Remesher::try_collapse(Index f, int i, double longest) {
  if (collapse(f, i, longest)) return true;
  const Index g = neighbor_[f][i];
  if (g >= 0) {
    const int j = opposite_corner(g, tri_[f][previous(i)], tri_[f][next(i)]);
    return collapse(g, j, longest);
  }
  return false;
}

// Removes the edge opposite corner i of f by moving its first end v onto its second end u.
bool Remesher::collapse(Index f, int i, double longest) {
  const Index v = tri_[f][next(i)], u = tri_[f][previous(i)], x = tri_[f][i];
  const Index g = neighbor_[f][i];
  if (on_boundary_[v] && (g >= 0 || !on_boundary_[u])) return false;
  if (g >= 0 && on_boundary_[u] && on_boundary_[v]) return false;

  collect_ring(u);
  other_vertices_ = ring_vertices_;
  collect_ring(v);
  int common = 0;
  for (const Index a : ring_vertices_)
    common += static_cast<int>(std::count(other_vertices_.begin(), other_vertices_.end(), a));
  if (common != (g >= 0 ? 2 : 1)) return false;
  if (other_vertices_.size() <= 3 && !on_boundary_[u]) return false;

  double error = 0;
  if (on_boundary_[v]) {
    const Index first = ring_vertices_.front(), last = ring_vertices_.back();
    const Index w = first == u ? last : first;
    if (w == u) return false;
    const Vec3 d = point_[w] - point_[u];
    const double s =
        std::clamp((point_[v] - point_[u]).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    error =
        (point_[u] + s * d - point_[v]).norm() + std::max(boundary_error_[v], boundary_error_[u]);
    if (error > target_.boundary_tolerance) return false;
  }
  for (const Index h : ring_) {
    if (h == f || h == g) continue;
    const int c = corner_of(h, v);
    if (!may_replace(h, c, point_[u])) return false;
    for (const int k : {next(c), previous(c)})
      if ((point_[tri_[h][k]] - point_[u]).squaredNorm() > longest * longest) return false;
  }

  const auto ear = [&](Index face, Index from, Index to, Index apex) {
    // Joins the two outer neighbours of a vanishing triangle (from, to, apex); from is replaced by
    // to.
    const Index across_from = neighbor_[face][corner_of(face, to)],
                across_to = neighbor_[face][corner_of(face, from)];
    return std::array<Index, 3>{across_from, across_to, apex};
  };
  const auto [f_v, f_u, apex_f] = ear(f, v, u, x);
  if (f_v < 0 && f_u < 0) return false;
  Index g_v = -1, g_u = -1, y = -1;
  if (g >= 0) {
    const int j = opposite_corner(g, u, v);
    const auto parts = ear(g, v, u, tri_[g][j]);
    g_v = parts[0];
    g_u = parts[1];
    y = parts[2];
    if (g_v < 0 && g_u < 0) return false;
  }

  // In f = (x, v, u) the edge (x, v) runs x→v, so its neighbour runs v→x.
  if (f_v >= 0) neighbor_[f_v][opposite_corner(f_v, v, x)] = f_u;
  if (f_u >= 0) neighbor_[f_u][opposite_corner(f_u, x, u)] = f_v;
  if (g >= 0) {
    if (g_v >= 0) neighbor_[g_v][opposite_corner(g_v, y, v)] = g_u;
    if (g_u >= 0) neighbor_[g_u][opposite_corner(g_u, u, y)] = g_v;
  }
  for (const Index h : ring_)
    if (h != f && h != g) tri_[h][corner_of(h, v)] = u;
  tri_[f] = {-1, -1, -1};
  if (g >= 0) tri_[g] = {-1, -1, -1};
  face_of_[v] = -1;
  face_of_[apex_f] = f_v >= 0 ? f_v : f_u;
  face_of_[u] = face_of_[apex_f];
  if (y >= 0) face_of_[y] = g_v >= 0 ? g_v : g_u;
  if (on_boundary_[v]) boundary_error_[u] = error;
  return true;
}

void Remesher::split_long_edges(double longest) {
  const double limit = longest * longest;
  // New triangles are appended and visited too, so that the loop ends with no long edge left.
  for (Index f = 0; f < static_cast<Index>(tri_.size()); ++f) {
    if (!alive(f)) continue;
    for (;;) {
      int worst = -1;
      double length = limit;
      for (int i = 0; i < 3; ++i) {
        const double squared =
            (point_[tri_[f][next(i)]] - point_[tri_[f][previous(i)]]).squaredNorm();
        if (squared > length) {
          length = squared;
          worst = i;
        }
      }
      if (worst < 0) break;
      split(f, worst);
    }
  }
}

void Remesher::split(Index f, int i) {
  const Index a = tri_[f][i], b = tri_[f][next(i)], c = tri_[f][previous(i)];
  const Index m = static_cast<Index>(point_.size());
  const Index g = neighbor_[f][i];
  const Vec3 middle = 0.5 * (point_[b] + point_[c]);
  point_.push_back(middle);
  on_boundary_.push_back(g < 0);
  boundary_error_.push_back(g < 0 ? std::max(boundary_error_[b], boundary_error_[c]) : 0);
  face_of_.push_back(f);

  const Index f2 = static_cast<Index>(tri_.size());
  const Index g2 = g >= 0 ? f2 + 1 : -1;
  const Index across_ab = neighbor_[f][previous(i)], across_ca = neighbor_[f][next(i)];
  tri_[f] = {a, b, m};
  neighbor_[f] = {g2, f2, across_ab};
  tri_.push_back({a, m, c});
  neighbor_.push_back({g, across_ca, f});
  point_to(across_ca, a, c, f2);
  face_of_[b] = f;
  face_of_[c] = f2;
  if (g < 0) return;

  const int j = opposite_corner(g, c, b);
  const Index d = tri_[g][j];
  const Index across_dc = neighbor_[g][previous(j)], across_bd = neighbor_[g][next(j)];
  tri_[g] = {d, c, m};
  neighbor_[g] = {f2, g2, across_dc};
  tri_.push_back({d, m, b});
  neighbor_.push_back({f, across_bd, g});
  point_to(across_bd, d, b, g2);
  face_of_[d] = g;
}

void Remesher::flip_edges() {
  constexpr int kSweeps = 3;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool changed = false;
    for (Index f = 0; f < static_cast<Index>(tri_.size()); ++f) {
      if (!alive(f)) continue;
      for (int i = 0; i < 3; ++i)
        if (neighbor_[f][i] > f) changed |= flip_if_better(f, i);
    }
    if (!changed) break;
  }
}

// Flips an edge whose opposite angles sum to more than π.
bool Remesher::flip_if_better(Index f, int i) {
  const Index g = neighbor_[f][i];
  const Index a = tri_[f][i], b = tri_[f][next(i)], c = tri_[f][previous(i)];
  const int j = opposite_corner(g, c, b);
  const Index d = tri_[g][j];
  if (a == d) return false;
  const Vec3 ab = point_[b] - point_[a], ac = point_[c] - point_[a];
  const Vec3 db = point_[b] - point_[d], dc = point_[c] - point_[d];
  const double cos_a = ab.dot(ac), sin_a = ab.cross(ac).norm(), cos_d = db.dot(dc),
               sin_d = db.cross(dc).norm();
  // sin(A + D) < 0 ⇔ A + D > π; the tolerance keeps cocircular quads from flipping to and fro.
  if (sin_a * cos_d + cos_a * sin_d > -1e-9 * ab.squaredNorm() * db.squaredNorm()) return false;

  const Vec3 reference = normal_2a(f) + normal_2a(g);
  const Vec3 n1 = normal_2a(point_[a], point_[b], point_[d]),
             n2 = normal_2a(point_[d], point_[c], point_[a]);
  const double length = reference.norm();
  if (n1.dot(reference) < kMinNormalCosine * length * n1.norm() ||
      n2.dot(reference) < kMinNormalCosine * length * n2.norm())
    return false;
  if (n1.norm() <= 0 || n2.norm() <= 0) return false;
  collect_ring(a);
  if (std::find(ring_vertices_.begin(), ring_vertices_.end(), d) != ring_vertices_.end())
    return false;

  const Index across_ab = neighbor_[f][previous(i)], across_ca = neighbor_[f][next(i)];
  const Index across_dc = neighbor_[g][previous(j)], across_bd = neighbor_[g][next(j)];
  tri_[f] = {a, b, d};
  neighbor_[f] = {across_bd, g, across_ab};
  tri_[g] = {d, c, a};
  neighbor_[g] = {across_ca, f, across_dc};
  point_to(across_bd, d, b, f);
  point_to(across_ca, a, c, g);
  face_of_[a] = face_of_[b] = face_of_[d] = f;
  face_of_[c] = g;
  return true;
}

// Moves interior vertices towards the centroid of their triangles, along the surface.
void Remesher::relax() {
  for (Index v = 0; v < static_cast<Index>(point_.size()); ++v) {
    if (face_of_[v] < 0 || on_boundary_[v]) continue;
    collect_ring(v);
    Vec3 center = Vec3::Zero(), normal = Vec3::Zero();
    double area = 0;
    for (const Index f : ring_) {
      const Vec3 n = normal_2a(f);
      const double weight = n.norm();
      center += weight / 3.0 * (point_[tri_[f][0]] + point_[tri_[f][1]] + point_[tri_[f][2]]);
      normal += n;
      area += weight;
    }
    const double normal_length = normal.norm();
    if (!(area > 0) || !(normal_length > 0)) continue;
    normal /= normal_length;
    Vec3 goal = center / area;
    goal -= normal * normal.dot(goal - point_[v]);
    const Closest hit = tree_.closest(goal, target_.edge_length);
    if (hit.triangle < 0) continue;
    if (triangle_normal_2a(raw_.surface.vertices, raw_.surface.triangles.row(hit.triangle))
            .dot(normal) < 0)
      continue;
    const bool valid = std::all_of(ring_.begin(), ring_.end(), [&](Index f) {
      return may_replace(f, corner_of(f, v), hit.point);
    });
    if (valid) point_[v] = hit.point;
  }
}

Isosurface Remesher::result() {
  Isosurface out;
  std::vector<Index> number(point_.size(), -1);
  Index vertices = 0, faces = 0;
  for (std::size_t f = 0; f < tri_.size(); ++f) {
    if (!alive(static_cast<Index>(f))) continue;
    ++faces;
    for (const Index v : tri_[f])
      if (number[v] < 0) number[v] = vertices++;
  }
  out.surface.vertices.resize(vertices, 3);
  out.normal.resize(vertices, 3);
  out.surface.triangles.resize(faces, 3);
  out.source_tet.reserve(faces);
  const double far = 10 * target_.edge_length;
  for (std::size_t v = 0; v < point_.size(); ++v) {
    if (number[v] < 0) continue;
    out.surface.vertices.row(number[v]) = point_[v].transpose();
    const Closest hit = tree_.closest(point_[v], far);
    const auto corners = raw_.surface.triangles.row(hit.triangle);
    Vec3 normal = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
      normal += hit.barycentric(i) * raw_.normal.row(corners(i)).transpose();
    const double length = normal.norm();
    if (length > 0)
      normal /= length;
    else
      normal = raw_.normal.row(corners(0)).transpose();
    out.normal.row(number[v]) = normal.transpose();
  }
  Index row = 0;
  for (std::size_t f = 0; f < tri_.size(); ++f) {
    if (!alive(static_cast<Index>(f))) continue;
    for (int i = 0; i < 3; ++i) out.surface.triangles(row, i) = number[tri_[f][i]];
    ++row;
    const Vec3 center = (point_[tri_[f][0]] + point_[tri_[f][1]] + point_[tri_[f][2]]) / 3.0;
    out.source_tet.push_back(raw_.source_tet[tree_.closest(center, far).triangle]);
  }
  return out;
}

}  // namespace

Isosurface remesh(const Isosurface& raw, const RemeshTarget& target, Context& ctx) {
  if (raw.surface.triangles.rows() == 0) return raw;
  return Remesher(raw, target, ctx).run();
}

}  // namespace s3
