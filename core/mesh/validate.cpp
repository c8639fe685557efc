#include "mesh/validate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "mesh/aabb_tree.h"
#include "mesh/exact_predicates.h"
#include "mesh/surface_edges.h"
#include "mesh/weld.h"

namespace s3 {

namespace {

constexpr std::size_t kPlacesKept = 100;
constexpr Index kTrianglesPerCheckpoint = 4096;
constexpr double kSmallestModel = 1, kLargestModel = 2000;  // mm

Vec3 vertex(const TriMesh& mesh, Index v) {
  return mesh.vertices.row(v);
}

Corners corners_of(const TriMesh& mesh, Index f) {
  return {vertex(mesh, mesh.triangles(f, 0)), vertex(mesh, mesh.triangles(f, 1)),
          vertex(mesh, mesh.triangles(f, 2))};
}

Vec3 centroid(const Corners& t) {
  return (t[0] + t[1] + t[2]) / 3;
}

void inspect_edges(const TriMesh& mesh, const std::vector<Side>& sides, MeshReport& report) {
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    const Vec3 middle = 0.5 * (vertex(mesh, sides[begin].low) + vertex(mesh, sides[begin].high));
    if (end - begin == 1)
      report.open_edges.add(middle);
    else if (end - begin > 2)
      report.nonmanifold_edges.add(middle);
    else if (sides[begin].forward == sides[begin + 1].forward)
      report.inconsistent_edges.add(middle);
  });
}

// The corners at a vertex form one fan when edges with two triangles join them all. Vertices on
// edges with more than two triangles are reported by the edge.
void inspect_vertices(const TriMesh& mesh, const std::vector<Side>& sides, MeshReport& report) {
  const auto corner_count = static_cast<std::size_t>(3 * mesh.triangles.rows());
  DisjointSets fans(corner_count);
  std::vector<char> on_bad_edge(static_cast<std::size_t>(mesh.vertices.rows()), 0);
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    for (const Index v : {sides[begin].low, sides[begin].high}) {
      if (end - begin == 2)
        fans.join(corner_at(mesh, sides[begin], v), corner_at(mesh, sides[begin + 1], v));
      if (end - begin > 2) on_bad_edge[static_cast<std::size_t>(v)] = 1;
    }
  });
  std::vector<Index> fan(on_bad_edge.size(), -1);
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    if (has_repeated_corner(mesh, f)) continue;
    for (int i = 0; i < 3; ++i) {
      const auto v = static_cast<std::size_t>(mesh.triangles(f, i));
      const Index leader = fans.find(3 * f + i);
      if (on_bad_edge[v] || fan[v] == leader) continue;
      if (fan[v] >= 0) {
        report.nonmanifold_vertices.add(mesh.vertices.row(mesh.triangles(f, i)));
        on_bad_edge[v] = 1;  // once is enough
      }
      fan[v] = leader;
    }
  }
  report.unused_vertices = 0;
  std::vector<char> used(on_bad_edge.size(), 0);
  for (Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) used[static_cast<std::size_t>(mesh.triangles(f, i))] = 1;
  report.unused_vertices = static_cast<Index>(std::count(used.begin(), used.end(), 0));
}

void inspect_triangles(const TriMesh& mesh, MeshReport& report, std::vector<char>& degenerate) {
  degenerate.assign(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  std::vector<std::array<Index, 4>> keys;  // sorted corners, triangle
  keys.reserve(degenerate.size());
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    const Corners corners = corners_of(mesh, f);
    if (has_repeated_corner(mesh, f) || is_degenerate(corners)) {
      degenerate[static_cast<std::size_t>(f)] = 1;
      report.degenerate_triangles.add(centroid(corners));
    }
    std::array<Index, 4> key = {mesh.triangles(f, 0), mesh.triangles(f, 1), mesh.triangles(f, 2),
                                f};
    std::sort(key.begin(), key.begin() + 3);
    keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (std::equal(keys[i].begin(), keys[i].begin() + 3, keys[i - 1].begin()))
      report.duplicate_triangles.add(centroid(corners_of(mesh, keys[i][3])));
}

// Turns the corners so that those shared with the other triangle come first. @return how many are
// shared
int shared_corners_first(const TriMesh& mesh, Index f, Index g, Corners& s, Corners& t) {
  std::array<int, 3> of_f{}, of_g{};
  int shared = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (mesh.triangles(f, i) == mesh.triangles(g, j)) {
        if (shared < 3)
          of_f[static_cast<std::size_t>(shared)] = i, of_g[static_cast<std::size_t>(shared)] = j;
        ++shared;
      }
  const auto arrange = [&](Index triangle, const std::array<int, 3>& first, Corners& out) {
    std::array<bool, 3> placed{};
    std::size_t n = 0;
    for (int k = 0; k < std::min(shared, 3); ++k) {
      const int i = first[static_cast<std::size_t>(k)];
      out[n++] = vertex(mesh, mesh.triangles(triangle, i));
      placed[static_cast<std::size_t>(i)] = true;
    }
    for (int i = 0; i < 3 && n < 3; ++i)
      if (!placed[static_cast<std::size_t>(i)])
        out[n++] = vertex(mesh, mesh.triangles(triangle, i));
  };
  arrange(f, of_f, s);
  arrange(g, of_g, t);
  return shared;
}

bool pair_intersects(const TriMesh& mesh, Index f, Index g) {
  Corners s, t;
  switch (shared_corners_first(mesh, f, g, s, t)) {
    case 0:
      return triangles_meet(s, t);
    case 1:
      return triangles_meet_beyond_corner(s, t);
    case 2:
      return triangles_fold_over_edge(s, t);
    default:
      return false;  // a duplicate, reported as such
  }
}

void find_intersections(const TriMesh& mesh, const std::vector<char>& degenerate,
                        const Context* ctx, MeshReport& report) {
  const AabbTree tree(mesh);
  std::vector<Index> candidates;
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    if (ctx && f % kTrianglesPerCheckpoint == 0) ctx->checkpoint();
    if (degenerate[static_cast<std::size_t>(f)]) continue;
    const Corners t = corners_of(mesh, f);
    tree.triangles_in_box({t[0].cwiseMin(t[1]).cwiseMin(t[2]), t[0].cwiseMax(t[1]).cwiseMax(t[2])},
                          candidates);
    std::sort(candidates.begin(), candidates.end());
    for (const Index g : candidates) {
      if (g <= f || degenerate[static_cast<std::size_t>(g)] || !pair_intersects(mesh, f, g))
        continue;
      report.self_intersections.add(0.5 * (centroid(t) + centroid(corners_of(mesh, g))));
      report.intersecting_pairs.push_back({f, g});
      if (report.self_intersections.count >= MeshReport::kMaxIntersections) return;
    }
  }
}

// Number of other shells that contain the middle of the shell's first triangle: parity of crossings
// along three rays, by majority. Not one of its corners: shells may touch there. What contains a
// shell is larger.
std::vector<Index> shell_depths(const TriMesh& mesh, const std::vector<Index>& shell,
                                const std::vector<Shell>& shells) {
  std::vector<Index> depth(shells.size(), 0);
  if (shells.size() == 1) return depth;
  const auto size = [&](Index s) { return std::abs(shells[static_cast<std::size_t>(s)].volume); };
  const AabbTree tree(mesh);
  // Directions without any relation to coordinates, so that rays miss edges and corners.
  const std::array<Vec3, 3> directions = {
      Vec3(0.3217, 0.7411, 0.5893), Vec3(-0.6131, 0.2239, 0.7577), Vec3(0.1733, -0.8311, -0.5287)};
  std::vector<char> seen(depth.size(), 0);
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    const Index own = shell[static_cast<std::size_t>(f)];
    if (seen[static_cast<std::size_t>(own)]) continue;
    seen[static_cast<std::size_t>(own)] = 1;
    std::vector<std::array<Index, 2>> votes;  // shell, ray; one for each crossing
    for (Index ray = 0; ray < 3; ++ray)
      for (const RayHit& hit :
           tree.all_hits(centroid(corners_of(mesh, f)), directions[static_cast<std::size_t>(ray)]))
        votes.push_back({shell[static_cast<std::size_t>(hit.triangle)], ray});
    std::sort(votes.begin(), votes.end());
    for (std::size_t begin = 0, end; begin < votes.size(); begin = end) {
      std::array<int, 3> crossings{};
      for (end = begin; end < votes.size() && votes[end][0] == votes[begin][0]; ++end)
        ++crossings[static_cast<std::size_t>(votes[end][1])];
      if (size(votes[begin][0]) > size(own) &&
          crossings[0] % 2 + crossings[1] % 2 + crossings[2] % 2 >= 2)
        ++depth[static_cast<std::size_t>(own)];
    }
  }
  return depth;
}

// In the order of connected_parts().
std::vector<Shell> measured_shells(const TriMesh& mesh, const std::vector<Index>& shell,
                                   Index count, bool closed) {
  std::vector<Shell> shells(static_cast<std::size_t>(count));
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    Shell& s = shells[static_cast<std::size_t>(shell[static_cast<std::size_t>(f)])];
    const Corners t = corners_of(mesh, f);
    if (s.triangles++ == 0) s.place = t[0];
    s.volume += (t[0] - s.place).dot((t[1] - s.place).cross(t[2] - s.place)) / 6;
  }
  if (!closed) return shells;
  const std::vector<Index> depth = shell_depths(mesh, shell, shells);
  for (std::size_t i = 0; i < shells.size(); ++i) {
    shells[i].depth = depth[i];
    shells[i].inverted = depth[i] % 2 == 0 ? shells[i].volume < 0 : shells[i].volume > 0;
  }
  return shells;
}

Shells measure_shells(const TriMesh& mesh, const std::vector<Side>& sides) {
  Shells result;
  Index count = 0;
  result.of_triangle = connected_parts(mesh, sides, false, count);
  result.shells = measured_shells(mesh, result.of_triangle, count, is_closed_and_oriented(sides));
  return result;
}

std::size_t open_edge_count(const TriMesh& mesh) {
  std::size_t count = 0;
  for_each_edge(sorted_sides(mesh),
                [&](std::size_t begin, std::size_t end) { count += end - begin == 1; });
  return count;
}

std::string counted(std::size_t n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

void drop_repeated_corners(TriMesh& mesh, std::vector<std::string>& repairs) {
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    if (!has_repeated_corner(mesh, f)) mesh.triangles.row(kept++) = mesh.triangles.row(f);
  const auto dropped = static_cast<std::size_t>(mesh.triangles.rows() - kept);
  if (dropped == 0) return;
  mesh.triangles.conservativeResize(kept, 3);
  repairs.push_back(counted(dropped, "triangle", "triangles") + " with a repeated corner removed");
}

void weld_if_it_closes(TriMesh& mesh, std::vector<std::string>& repairs) {
  const std::size_t open = open_edge_count(mesh);
  if (open == 0) return;
  TriMesh welded;
  Welder welder(static_cast<std::size_t>(mesh.vertices.rows()));
  std::vector<Index> number;
  number.reserve(static_cast<std::size_t>(mesh.vertices.rows()));
  for (Index v = 0; v < mesh.vertices.rows(); ++v) number.push_back(welder.add(vertex(mesh, v)));
  welded.vertices = welder.take();
  if (welded.vertices.rows() == mesh.vertices.rows()) return;
  welded.triangles =
      mesh.triangles.unaryExpr([&](Index v) { return number[static_cast<std::size_t>(v)]; });
  if (open_edge_count(welded) >= open) return;
  repairs.push_back(counted(static_cast<std::size_t>(mesh.vertices.rows() - welded.vertices.rows()),
                            "vertex", "vertices") +
                    " with the coordinates of another joined with it");
  mesh = std::move(welded);
  drop_repeated_corners(mesh, repairs);
}

// A shell without any shell around it must face outward; when every shell is the wrong way round,
// the file means it so.
void turn_inverted_shells(TriMesh& mesh, std::vector<std::string>& repairs) {
  const std::vector<Side> sides = sorted_sides(mesh);
  if (mesh.triangles.rows() == 0 || !is_closed_and_oriented(sides)) return;
  Index count = 0;
  const std::vector<Index> shell = connected_parts(mesh, sides, false, count);
  const std::vector<Shell> shells = measured_shells(mesh, shell, count, true);
  const bool all =
      std::all_of(shells.begin(), shells.end(), [](const Shell& s) { return s.inverted; });
  std::size_t turned = 0;
  std::vector<char> turn(shells.size(), 0);
  for (std::size_t i = 0; i < shells.size(); ++i)
    turned += turn[i] = shells[i].inverted && (all || shells[i].depth == 0);
  if (turned == 0) return;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    if (turn[static_cast<std::size_t>(shell[static_cast<std::size_t>(f)])])
      std::swap(mesh.triangles(f, 1), mesh.triangles(f, 2));
  repairs.push_back(counted(turned, "shell that was", "shells that were") + " inside out turned");
}

std::string at_place(const Defect& defect) {
  if (defect.where.empty()) return "";
  char text[100];
  const Vec3& p = defect.where[0];
  std::snprintf(text, sizeof text, " near (%.4g, %.4g, %.4g)", p.x(), p.y(), p.z());
  return text;
}

void require_none(const Defect& defect, const char* code, const std::string& what,
                  const std::string& hint) {
  if (defect.count == 0) return;
  throw Error(ErrorKind::input, Stage::mesh, code,
              "The surface has " + std::to_string(defect.count) + " " + what + at_place(defect),
              hint, defect.where);
}

}  // namespace

void Defect::add(const Vec3& place) {
  ++count;
  if (where.size() < kPlacesKept) where.push_back(place);
}

Index MeshReport::inverted_shells() const {
  return static_cast<Index>(
      std::count_if(shells.begin(), shells.end(), [](const Shell& s) { return s.inverted; }));
}

bool MeshReport::valid() const {
  return triangles > 0 && degenerate_triangles.count == 0 && duplicate_triangles.count == 0 &&
         open_edges.count == 0 && nonmanifold_edges.count == 0 && inconsistent_edges.count == 0 &&
         nonmanifold_vertices.count == 0 && self_intersections.count == 0 && inverted_shells() == 0;
}

MeshReport inspect_surface(const TriMesh& mesh, const Context* ctx) {
  MeshReport report;
  report.vertices = static_cast<Index>(mesh.vertices.rows());
  report.triangles = static_cast<Index>(mesh.triangles.rows());
  if (report.triangles == 0) return report;
  report.box = bounding_box(mesh.vertices);
  report.area = surface_area(mesh);
  report.volume = enclosed_volume(mesh);

  const std::vector<Side> sides = sorted_sides(mesh);
  std::vector<char> degenerate;
  inspect_edges(mesh, sides, report);
  inspect_vertices(mesh, sides, report);
  inspect_triangles(mesh, report, degenerate);
  find_intersections(mesh, degenerate, ctx, report);

  report.shells = measure_shells(mesh, sides).shells;
  std::stable_sort(report.shells.begin(), report.shells.end(), [](const Shell& a, const Shell& b) {
    return std::abs(a.volume) > std::abs(b.volume);
  });
  return report;
}

Shells measure_shells(const TriMesh& mesh) {
  return measure_shells(mesh, sorted_sides(mesh));
}

void require_valid_surface(const MeshReport& report) {
  if (report.triangles == 0)
    throw Error(ErrorKind::input, Stage::mesh, "mesh.empty", "The surface has no triangles",
                "Export the model with its faces");
  require_none(report.open_edges, "mesh.open_boundary", "open edges",
               "Close the holes in your CAD or mesh program");
  require_none(report.nonmanifold_edges, "mesh.non_manifold", "edges with more than two triangles",
               "Remove inner walls and join the bodies by a boolean union");
  require_none(report.inconsistent_edges, "mesh.inconsistent_orientation",
               "edges between triangles that face opposite ways",
               "Recalculate the normals in your mesh program");
  require_none(report.nonmanifold_vertices, "mesh.non_manifold",
               "vertices where parts touch in a point only",
               "Separate the parts or let them overlap in a boolean union");
  require_none(report.duplicate_triangles, "mesh.duplicate_triangles", "duplicate triangles",
               "Remove doubled faces in your mesh program");
  require_none(report.degenerate_triangles, "mesh.degenerate", "triangles without area",
               "Remesh the surface or dissolve degenerate faces in your mesh program");
  require_none(report.self_intersections, "mesh.self_intersection",
               report.self_intersections.count >= MeshReport::kMaxIntersections
                   ? "or more pairs of triangles that intersect"
                   : "pairs of triangles that intersect",
               "Join overlapping bodies by a boolean union");
  for (const Shell& shell : report.shells)
    if (shell.inverted)
      require_none({report.inverted_shells(), {shell.place}}, "mesh.inverted",
                   shell.depth % 2 == 1 ? "bodies inside another body" : "shells that face inward",
                   "Flip the normals of this part, or remove it");
}

std::vector<std::string> clean_surface(TriMesh& mesh) {
  std::vector<std::string> repairs;
  drop_repeated_corners(mesh, repairs);
  weld_if_it_closes(mesh, repairs);
  if (const Index dropped = drop_unused_vertices(mesh))
    repairs.push_back(
        counted(static_cast<std::size_t>(dropped), "unused vertex", "unused vertices") +
        " removed");
  turn_inverted_shells(mesh, repairs);
  return repairs;
}

void warn_about_units(const Box& box, Context& ctx) {
  const double size = (box.max - box.min).maxCoeff();
  if (size >= kSmallestModel && size <= kLargestModel) return;
  char text[160];
  std::snprintf(text, sizeof text,
                "The model is %.4g mm large; if its file is not in millimetres, set input.scale",
                size);
  ctx.warn("mesh.units", text);
}

}  // namespace s3
