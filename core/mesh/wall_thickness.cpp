// Thickness along the inward normal: the shape diameter function of Shapira et al. 2008 with a
// single ray.
#include "mesh/wall_thickness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "mesh/aabb_tree.h"
#include "mesh/surface_points.h"

namespace s3 {
namespace {

constexpr std::size_t kSamples = 16384;
constexpr double kOpposite = -0.866;  // cos 150°
constexpr double kEdgePerThickness = 0.42;
constexpr int kLeastTarget = 30000, kMostTarget = 1000000;
constexpr double kMostTets = 5e6;  // that a job may ask for
constexpr double kOnSide = 0.2;    // of the thickness: so near to a side a corner lies on it
constexpr int kMostSteps = 1000;   // tets along a wall

std::optional<Wall> wall_at(const Directions& normals, const AabbTree& tree,
                            const SurfacePoint& sample, double clearance) {
  const Vec3 inward = -normals.row(sample.face).transpose();
  const RayHit hit = tree.first_hit(sample.point + clearance * inward, inward);
  if (hit.triangle < 0 || normals.row(hit.triangle).dot(-inward) > kOpposite) return std::nullopt;
  return Wall{sample.point, sample.point + (hit.t + clearance) * inward};
}

/// Walks along walls from tet to tet.
class WallWalker {
 public:
  explicit WallWalker(const TetMesh& mesh)
      : mesh_(mesh),
        tree_(mesh.vertices, mesh.boundary_faces),
        on_boundary_(static_cast<std::size_t>(mesh.vertex_count()), 0) {
    for (Eigen::Index i = 0; i < mesh.boundary_faces.size(); ++i)
      on_boundary_[static_cast<std::size_t>(mesh.boundary_faces.data()[i])] = 1;
  }

  bool has_single_tet(const Wall& wall) const {
    const double thickness = wall.thickness();
    const Vec3 direction = (wall.to - wall.from) / thickness;
    const Closest start = tree_.closest(wall.from, thickness);
    if (start.triangle < 0) return false;  // the mesh left this wall out
    Index t = mesh_.boundary_face_tet[static_cast<std::size_t>(start.triangle)];
    double passed = 0;
    for (int step = 0; step < kMostSteps && t >= 0 && passed < thickness; ++step) {
      if (spans(t, wall.from, direction, thickness)) return true;
      const auto [face, at] = way_out(t, wall.from, direction);
      passed = at;
      t = mesh_.neighbors(t, face);
    }
    return false;
  }

 private:
  struct WayOut {
    int face;
    double at;  // mm along the wall
  };

  bool spans(Index t, const Vec3& from, const Vec3& direction, double thickness) const {
    bool near = false, far = false;
    for (int i = 0; i < 4; ++i) {
      if (!on_boundary_[static_cast<std::size_t>(mesh_.tets(t, i))]) continue;
      const double depth = (mesh_.corner(t, i) - from).dot(direction);
      near = near || depth < kOnSide * thickness;
      far = far || depth > (1 - kOnSide) * thickness;
    }
    return near && far;
  }

  WayOut way_out(Index t, const Vec3& from, const Vec3& direction) const {
    WayOut out{0, std::numeric_limits<double>::infinity()};
    for (int f = 0; f < 4; ++f) {
      const auto& local = kTetFaces[static_cast<std::size_t>(f)];
      const Vec3 a = mesh_.corner(t, local[0]), b = mesh_.corner(t, local[1]),
                 c = mesh_.corner(t, local[2]);
      const Vec3 normal = (b - a).cross(c - a);
      const double along = normal.dot(direction);
      if (along <= 0) continue;
      const double at = normal.dot(a - from) / along;
      if (at < out.at) out = {f, at};
    }
    return out;
  }

  const TetMesh& mesh_;
  AabbTree tree_;
  std::vector<char> on_boundary_;
};

}  // namespace

const Wall* WallThickness::thinnest() const {
  const auto rank = static_cast<std::size_t>(kLeastArea * static_cast<double>(samples));
  return rank < walls.size() ? &walls[rank] : nullptr;
}

WallThickness measure_walls(const TriMesh& surface, Context& ctx) {
  const std::vector<SurfacePoint> samples = spread_points(surface, kSamples);
  const AabbTree tree(surface);
  const Directions normals = triangle_normals(surface);
  const double clearance = 1e-6 * bounding_box(surface.vertices).diagonal();
  std::vector<std::optional<Wall>> found(samples.size());
  constexpr std::size_t kGrain = 1024;
  parallel_for(ctx.pool, samples.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    for (std::size_t i = begin; i < end; ++i)
      found[i] = wall_at(normals, tree, samples[i], clearance);
  });
  WallThickness result;
  result.samples = samples.size();
  for (const std::optional<Wall>& wall : found)
    if (wall) result.walls.push_back(*wall);
  std::stable_sort(result.walls.begin(), result.walls.end(),
                   [](const Wall& a, const Wall& b) { return a.thickness() < b.thickness(); });
  return result;
}

double tets_for_wall(double volume, double thickness) {
  const double edge = kEdgePerThickness * thickness;
  return volume * 6 * std::sqrt(2.0) / (edge * edge * edge);  // a regular tet: edge³/(6√2)
}

int automatic_target(const TriMesh& surface, const WallThickness& walls) {
  const Wall* thinnest = walls.thinnest();
  if (!thinnest) return kLeastTarget;
  const double tets = tets_for_wall(enclosed_volume(surface), thinnest->thickness());
  return static_cast<int>(std::clamp<double>(tets, kLeastTarget, kMostTarget));
}

WallThickness unresolved_walls(const TetMesh& mesh, const WallThickness& walls, Context& ctx) {
  const WallWalker walker(mesh);
  std::vector<char> single(walls.walls.size(), 0);
  constexpr std::size_t kGrain = 1024;
  parallel_for(ctx.pool, single.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    for (std::size_t i = begin; i < end; ++i) single[i] = walker.has_single_tet(walls.walls[i]);
  });
  WallThickness result;
  result.samples = walls.samples;
  for (std::size_t i = 0; i < single.size(); ++i)
    if (single[i]) result.walls.push_back(walls.walls[i]);
  return result;
}

void warn_about_thin_walls(const TetMesh& mesh, const WallThickness& walls, int target,
                           Context& ctx) {
  const WallThickness unresolved = unresolved_walls(mesh, walls, ctx);
  const Wall* thinnest = unresolved.thinnest();
  if (!thinnest) return;
  const double needed = tets_for_wall(tet_volumes(mesh).sum(), thinnest->thickness());
  const Vec3 place = 0.5 * (thinnest->from + thinnest->to);
  const double share = 100.0 * static_cast<double>(unresolved.walls.size()) /
                       static_cast<double>(unresolved.samples);
  std::array<char, 400> text{};
  const int length = std::snprintf(
      text.data(), text.size(),
      "The wall of %.3g mm near (%.4g, %.4g, %.4g) has a single tet across, as has %.0f %% of the "
      "surface with %d tets; ",
      thinnest->thickness(), place.x(), place.y(), place.z(), share, target);
  const std::size_t left = text.size() - static_cast<std::size_t>(length);
  if (needed <= kMostTets)
    std::snprintf(text.data() + length, left, "two across take mesh.target_tets of about %.0f",
                  std::ceil(needed / 1000) * 1000);
  else
    std::snprintf(text.data() + length, left,
                  "two across would take %.1f million tets, more than can be asked for",
                  needed / 1e6);
  ctx.warn("tetrahedralize.thin_wall", text.data(), {place});
}

}  // namespace s3
