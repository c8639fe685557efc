// Feature matching by moving boundary vertices: in the spirit of Doran, Chang, Bridson 2013,
// "Isosurface Stuffing Improved"; which vertices go to a sharp edge is a small vertex cover.
#include "tetrahedralize/fit_boundary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "mesh/validate.h"
#include "tetrahedralize/quality.h"

namespace s3 {

namespace {

// Distances as shares of the lattice's edge.
constexpr double kOnSurface = 0.35;   // a boundary vertex this near belongs to the surface
constexpr double kCurveReach = 0.75;  // how far a vertex may go to a sharp edge
constexpr double kCornerReach = 1.0;  // and to a corner
constexpr double kArrived = 1e-9;
// Sines of dihedral angles: what a move must keep, and what smoothing works for.
constexpr double kKeepSine = 0.14;    // 8°
constexpr double kWantedSine = 0.45;  // 27°
// Less than this decides nothing: symmetric shapes are full of ties, which rounding breaks
// differently on every platform.
constexpr double kTie = 1e-7;
constexpr int kRounds = 10;
constexpr int kFinalSweeps = 6;
// How often the fit starts again with vertices kept in place; then all of them stay.
constexpr int kAttempts = 4;

enum class Bond : char { inner, surface, curve, corner, fixed };

class Fit {
 public:
  Fit(TetMesh& mesh, const SurfaceSolid& solid, const FeatureCurves& curves, double size,
      const std::vector<char>& fixed, Context& ctx)
      : mesh_(mesh), solid_(solid), curves_(curves), size_(size), ctx_(ctx) {
    list_tets();
    list_edges();
    bind_to_surface(fixed);
  }

  void run() {
    choose_corners();
    choose_curve_vertices();
    for (int round = 0; round < kRounds; ++round) {
      const bool waiting = pull();
      smooth();
      if (!waiting) break;
    }
    release_those_left();
    for (int sweep = 0; sweep < kFinalSweeps; ++sweep)
      if (!smooth()) break;
    even_out();
  }

 private:
  // --- the mesh ----------------------------------------------------------------------------------

  void list_tets() {
    first_tet_.assign(static_cast<std::size_t>(mesh_.vertex_count()) + 1, 0);
    for (Eigen::Index i = 0; i < mesh_.tets.size(); ++i)
      ++first_tet_[static_cast<std::size_t>(mesh_.tets.data()[i]) + 1];
    for (std::size_t v = 1; v < first_tet_.size(); ++v) first_tet_[v] += first_tet_[v - 1];
    std::vector<Index> next(first_tet_.begin(), first_tet_.end() - 1);
    tets_.resize(static_cast<std::size_t>(mesh_.tets.size()));
    for (Index t = 0; t < mesh_.tet_count(); ++t)
      for (int i = 0; i < 4; ++i)
        tets_[static_cast<std::size_t>(next[static_cast<std::size_t>(mesh_.tets(t, i))]++)] = t;
  }

  void list_edges() {
    for (Eigen::Index f = 0; f < mesh_.boundary_faces.rows(); ++f)
      for (int i = 0; i < 3; ++i) {
        const Index a = mesh_.boundary_faces(f, i), b = mesh_.boundary_faces(f, (i + 1) % 3);
        if (a < b) edges_.push_back({a, b});
      }
    std::sort(edges_.begin(), edges_.end());
  }

  Vec3 at(Index v) const { return mesh_.vertices.row(v); }
  void put(Index v, const Vec3& p) { mesh_.vertices.row(v) = p; }
  Bond& bond(Index v) { return bond_[static_cast<std::size_t>(v)]; }

  double sine(Index t) const {
    return least_sine(mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2),
                      mesh_.corner(t, 3));
  }

  // The smallest sine around a vertex; stops early below `enough`.
  double quality(Index v, double enough = -1) const {
    double least = 1;
    for (Index i = first_tet_[static_cast<std::size_t>(v)];
         i < first_tet_[static_cast<std::size_t>(v) + 1]; ++i) {
      least = std::min(least, sine(tets_[static_cast<std::size_t>(i)]));
      if (least <= enough) return least;
    }
    return least;
  }

  // --- bonds -------------------------------------------------------------------------------------

  void bind_to_surface(const std::vector<char>& fixed) {
    const auto n = static_cast<std::size_t>(mesh_.vertex_count());
    bond_.assign(n, Bond::inner);
    normal_.assign(n, Vec3::Zero());
    target_.assign(n, Vec3::Zero());
    for (Eigen::Index i = 0; i < mesh_.boundary_faces.size(); ++i)
      boundary_.push_back(mesh_.boundary_faces.data()[i]);
    std::sort(boundary_.begin(), boundary_.end());
    boundary_.erase(std::unique(boundary_.begin(), boundary_.end()), boundary_.end());
    for (const Index v : boundary_) {
      const Closest closest = solid_.tree.closest(at(v), kOnSurface * size_);
      // What is far from the surface closes a hole and stays as it is.
      const bool stays = closest.triangle < 0 || fixed[static_cast<std::size_t>(v)];
      bond(v) = stays ? Bond::fixed : Bond::surface;
      if (closest.triangle >= 0) normal_[static_cast<std::size_t>(v)] = solid_.normal(closest);
    }
  }

  // Each corner takes the nearest vertex.
  void choose_corners() {
    if (curves_.corners.empty()) return;
    Triangles points(static_cast<Eigen::Index>(boundary_.size()), 3);
    for (std::size_t i = 0; i < boundary_.size(); ++i)
      points.row(static_cast<Eigen::Index>(i)).setConstant(boundary_[i]);
    const AabbTree tree(mesh_.vertices, points);
    for (const Vec3& corner : curves_.corners) {
      const Closest closest = tree.closest(corner, kCornerReach * size_);
      if (closest.triangle < 0) continue;
      const Index v = boundary_[static_cast<std::size_t>(closest.triangle)];
      if (bond(v) != Bond::surface) continue;
      bond(v) = Bond::corner;
      target_[static_cast<std::size_t>(v)] = corner;
    }
  }

  // A boundary edge over a sharp edge of the surface: the surface has different normals at its
  // ends, and a sharp edge is near.
  bool crosses_curve(const std::array<Index, 2>& edge) {
    const auto& [a, b] = edge;
    if (bond(a) == Bond::fixed || bond(b) == Bond::fixed) return false;
    const Vec3 &na = normal_[static_cast<std::size_t>(a)],
               &nb = normal_[static_cast<std::size_t>(b)];
    if (na.dot(nb) > kSharpCosine) return false;
    const Vec3 middle = 0.5 * (at(a) + at(b));
    return curves_.segments.closest(middle, (at(a) - at(b)).norm()).triangle >= 0;
  }

  // Each edge over a curve must have an end that goes to the curve: the nearest vertices first,
  // then those are let go that no edge needs.
  void choose_curve_vertices() {
    if (curves_.segments.empty()) return;
    std::vector<std::array<Index, 2>> crossing;
    for (const auto& edge : edges_)
      if (crosses_curve(edge)) crossing.push_back(edge);
    std::vector<std::pair<Index, Index>> at_vertex;  // vertex, crossing edge
    for (std::size_t e = 0; e < crossing.size(); ++e)
      for (const Index v : crossing[e]) at_vertex.emplace_back(v, static_cast<Index>(e));
    std::sort(at_vertex.begin(), at_vertex.end());
    const auto edges_of = [&](Index v) {
      return std::equal_range(at_vertex.begin(), at_vertex.end(), std::pair(v, Index{0}),
                              [](const auto& a, const auto& b) { return a.first < b.first; });
    };

    std::vector<std::pair<long, Index>> candidates;
    for (std::size_t i = 0; i < at_vertex.size(); ++i) {
      const Index v = at_vertex[i].first;
      if ((i > 0 && at_vertex[i - 1].first == v) || bond(v) == Bond::corner) continue;
      const Closest closest = curves_.segments.closest(at(v), kCurveReach * size_);
      if (closest.triangle < 0) continue;
      target_[static_cast<std::size_t>(v)] = closest.point;
      candidates.emplace_back(std::lround(closest.distance / (kTie * size_)), v);
    }
    std::sort(candidates.begin(), candidates.end());
    std::vector<int> covered(crossing.size(), 0);
    const auto cover = [&](Index v, int by) {
      const auto [begin, end] = edges_of(v);
      for (auto it = begin; it != end; ++it) covered[static_cast<std::size_t>(it->second)] += by;
    };
    for (const Index v : boundary_)
      if (bond(v) == Bond::corner) cover(v, 1);
    for (const auto& [distance, v] : candidates) {
      const auto [begin, end] = edges_of(v);
      if (std::all_of(begin, end, [&](const auto& e) {
            return covered[static_cast<std::size_t>(e.second)] > 0;
          }))
        continue;
      bond(v) = Bond::curve;
      cover(v, 1);
    }
    for (auto it = candidates.rbegin(); it != candidates.rend(); ++it) {
      const Index v = it->second;
      if (bond(v) != Bond::curve) continue;
      const auto [begin, end] = edges_of(v);
      if (!std::all_of(begin, end, [&](const auto& e) {
            return covered[static_cast<std::size_t>(e.second)] > 1;
          }))
        continue;
      bond(v) = Bond::surface;
      cover(v, -1);
    }
  }

  // --- moves -------------------------------------------------------------------------------------

  bool has_target(Index v) { return bond(v) == Bond::curve || bond(v) == Bond::corner; }
  bool has_arrived(Index v) const {
    return (at(v) - target_[static_cast<std::size_t>(v)]).norm() <= kArrived * size_;
  }

  // Chosen vertices go towards their targets as far as the tets around allow. @return true if one
  // is still on its way
  bool pull() {
    bool waiting = false;
    for (const Index v : boundary_) {
      if (!has_target(v) || has_arrived(v)) continue;
      const Vec3 from = at(v), way = target_[static_cast<std::size_t>(v)] - from;
      const double bound = std::min(kKeepSine, quality(v));
      bool moved = false;
      for (double share = 1; share > 0.1 && !moved; share *= 0.5) {
        put(v, share == 1 ? target_[static_cast<std::size_t>(v)] : Vec3(from + share * way));
        moved = quality(v, bound - 1e-12) >= bound;
      }
      if (!moved) put(v, from);
      waiting = waiting || !has_arrived(v);
    }
    return waiting;
  }

  // Vertices that could not reach their curve return to the surface.
  void release_those_left() {
    for (const Index v : boundary_) {
      if (!has_target(v) || has_arrived(v)) continue;
      bond(v) = Bond::surface;
      const Vec3 from = at(v);
      const Closest closest = solid_.tree.closest(from, size_);
      if (closest.triangle < 0) continue;
      const double bound = std::min(kKeepSine, quality(v));
      put(v, closest.point);
      if (quality(v, bound - 1e-12) < bound) put(v, from);
    }
  }

  // A place near p that keeps the vertex's bond. @return false if there is none
  bool constrain(Index v, Vec3& p) {
    switch (bond(v)) {
      case Bond::inner:
        return true;
      case Bond::corner:
      case Bond::fixed:
        return false;
      case Bond::surface: {
        const Closest closest = solid_.tree.closest(p, kOnSurface * size_);
        if (closest.triangle < 0) return false;
        // Not around a sharp edge.
        if (solid_.normal(closest).dot(normal_[static_cast<std::size_t>(v)]) < kSharpCosine)
          return false;
        p = closest.point;
        return true;
      }
      case Bond::curve: {
        if (!has_arrived(v)) return false;
        const Closest closest = curves_.segments.closest(p, kOnSurface * size_);
        if (closest.triangle < 0) return false;
        p = closest.point;
        return true;
      }
    }
    return false;
  }

  // With all vertices on the surface, faces cut off what bulges: the distance is one-sided and the
  // volume too small (too large in hollows). Vertices go out by as much as faces lie in.
  void even_out() {
    // Of a triangle with its corners on a sphere: the mean depth over the depth in the middle.
    constexpr double kMeanDepth = 0.75;
    constexpr double kFlatShare = 0.1;  // a vertex beside a flat face stays in its plane
    const std::vector<Depths> depths = depths_of_faces();
    for (const Index v : boundary_) {
      const Depths& around = depths[static_cast<std::size_t>(v)];
      const double mean = around.sum / around.faces;
      if (bond(v) != Bond::surface || around.least < kFlatShare * std::abs(mean)) continue;
      const Vec3 from = at(v), p = from + kMeanDepth * mean * normal_[static_cast<std::size_t>(v)];
      // The model stands on the plate with the lowest point of its surface.
      if ((p.array() < solid_.box.min.array()).any() || (p.array() > solid_.box.max.array()).any())
        continue;
      const double bound = std::min(kKeepSine, quality(v));
      put(v, p);
      if (quality(v, bound - 1e-12) < bound) put(v, from);
    }
  }

  // How deep the middles of a vertex's boundary faces lie under the surface, mm.
  struct Depths {
    double sum = 0, least = std::numeric_limits<double>::infinity();  // least: of the amounts
    int faces = 0;
  };

  std::vector<Depths> depths_of_faces() const {
    std::vector<Depths> depths(static_cast<std::size_t>(mesh_.vertex_count()));
    for (Eigen::Index f = 0; f < mesh_.boundary_faces.rows(); ++f) {
      const auto face = mesh_.boundary_faces.row(f);
      const Vec3 middle = (at(face(0)) + at(face(1)) + at(face(2))) / 3;
      const Closest closest = solid_.tree.closest(middle, kOnSurface * size_);
      const Vec3 normal = triangle_normal_2a(mesh_.vertices, face).normalized();
      const double depth = closest.triangle < 0 ? 0 : (closest.point - middle).dot(normal);
      for (int i = 0; i < 3; ++i) {
        Depths& at_vertex = depths[static_cast<std::size_t>(face(i))];
        at_vertex.sum += depth;
        at_vertex.least = std::min(at_vertex.least, std::abs(depth));
        ++at_vertex.faces;
      }
    }
    return depths;
  }

  // Vertices with poor tets look around for a better place. @return true if one has found it
  bool smooth() {
    bool any = false;
    constexpr Index kVerticesPerCheckpoint = 1024;
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      if (v % kVerticesPerCheckpoint == 0) ctx_.checkpoint();
      const double now = quality(v);
      if (now < kWantedSine && improve(v, now)) any = true;
    }
    return any;
  }

  bool improve(Index v, double now) {
    if (bond(v) == Bond::corner || bond(v) == Bond::fixed) return false;
    constexpr double kGain = 1e-3;
    constexpr std::array<double, 4> kSteps = {0.2, 0.1, 0.05, 0.02};
    bool any = false;
    for (const double step : kSteps) {
      const Vec3 from = at(v);
      Vec3 best = from;
      double best_quality = now + kGain;
      for (int i = 0; i < 27; ++i) {
        if (i == 13) continue;
        const Vec3 direction = Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1).cast<double>();
        Vec3 p = from + step * size_ / direction.norm() * direction;
        if (!constrain(v, p)) continue;
        put(v, p);
        const double enough = best_quality + kTie;
        if (const double q = quality(v, enough); q > enough) {
          best_quality = q;
          best = p;
        }
      }
      put(v, best);
      if (best != from) {
        now = best_quality;
        any = true;
        if (bond(v) == Bond::curve) target_[static_cast<std::size_t>(v)] = best;
      }
    }
    return any;
  }

  TetMesh& mesh_;
  const SurfaceSolid& solid_;
  const FeatureCurves& curves_;
  const double size_;
  Context& ctx_;

  std::vector<Index> first_tet_, tets_;  // the tets around each vertex
  std::vector<std::array<Index, 2>> edges_;
  std::vector<Index> boundary_;  // vertices, sorted
  std::vector<Bond> bond_;
  std::vector<Vec3> normal_;  // of the surface at the vertex's first place
  std::vector<Vec3> target_;  // of vertices bound to a curve or corner
};

// Marks the vertices of boundary faces that meet others, and those of the faces beside. @return
// false if there are none
bool mark_crossings(const TetMesh& mesh, std::vector<char>& fixed, const Context& ctx) {
  const MeshReport report = inspect_surface(boundary_surface(mesh), &ctx);
  if (report.self_intersections.count == 0) return false;
  std::vector<char> crossing(fixed.size(), 0);
  for (const auto& pair : report.intersecting_pairs)
    for (const Index face : pair)
      for (int i = 0; i < 3; ++i)
        crossing[static_cast<std::size_t>(mesh.boundary_faces(face, i))] = 1;
  for (Eigen::Index f = 0; f < mesh.boundary_faces.rows(); ++f) {
    bool beside = false;
    for (int i = 0; i < 3; ++i)
      beside = beside || crossing[static_cast<std::size_t>(mesh.boundary_faces(f, i))];
    for (int i = 0; beside && i < 3; ++i)
      fixed[static_cast<std::size_t>(mesh.boundary_faces(f, i))] = 1;
  }
  return true;
}

}  // namespace

void fit_boundary(TetMesh& mesh, const SurfaceSolid& solid, const FeatureCurves& curves,
                  double size, Context& ctx) {
  const Points start = mesh.vertices;
  std::vector<char> fixed(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Fit(mesh, solid, curves, size, fixed, ctx).run();
    if (!mark_crossings(mesh, fixed, ctx)) return;
    mesh.vertices = start;
  }
}

}  // namespace s3
