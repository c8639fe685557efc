#include "mesh/recut_crossings.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mesh/fill_holes.h"
#include "mesh/split_nonmanifold.h"
#include "mesh/stitch.h"
#include "mesh/surface_edges.h"

namespace s3 {

namespace {

constexpr double kMostArea = 0.05, kMostVolume = 0.01;  // of the surface
constexpr int kRounds = 8, kMostRings = 3;
constexpr double kIsland = 1e-3;  // of the area: loose pieces below it go with the cut

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

bool crosses_other_shell(const TriMesh& mesh, const MeshReport& report) {
  const Shells shells = measure_shells(mesh);
  return std::any_of(report.intersecting_pairs.begin(), report.intersecting_pairs.end(),
                     [&](const auto& pair) {
                       return shells.of_triangle[at(pair[0])] != shells.of_triangle[at(pair[1])];
                     });
}

double area_of(const TriMesh& mesh, Index f) {
  return 0.5 * triangle_normal_2a(mesh.vertices, mesh.triangles.row(f)).norm();
}

// Adds the triangles around the vertices of those marked.
void grow(const TriMesh& mesh, std::vector<char>& marked) {
  std::vector<char> touched(at(static_cast<Index>(mesh.vertices.rows())), 0);
  for (Index f = 0; f < mesh.triangles.rows(); ++f)
    if (marked[at(f)])
      for (int i = 0; i < 3; ++i) touched[at(mesh.triangles(f, i))] = 1;
  for (Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i)
      if (touched[at(mesh.triangles(f, i))]) marked[at(f)] = 1;
}

// Pieces that the cut leaves without any connection to the rest.
void mark_islands(const TriMesh& mesh, double whole, std::vector<char>& marked) {
  TriMesh rest = mesh;
  std::vector<char> keep(marked.size());
  std::vector<Index> original;
  for (std::size_t f = 0; f < keep.size(); ++f) {
    keep[f] = !marked[f];
    if (keep[f]) original.push_back(static_cast<Index>(f));
  }
  keep_triangles(rest, keep);
  Index count = 0;
  const std::vector<Side> sides = sorted_sides(rest);
  const std::vector<Index> part = connected_parts(rest, sides, false, count);
  std::vector<double> area(at(count), 0);
  std::vector<char> open(at(count), 0);
  for (Index f = 0; f < rest.triangles.rows(); ++f) area[at(part[at(f)])] += area_of(rest, f);
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin == 1) open[at(part[at(sides[begin].triangle())])] = 1;
  });
  for (std::size_t f = 0; f < original.size(); ++f)
    if (open[at(part[f])] && area[at(part[f])] < kIsland * whole) marked[at(original[f])] = 1;
}

// The surface without the marked triangles, closed anew.
Recut cut_and_close(const TriMesh& mesh, const std::vector<char>& marked, Context& ctx) {
  Recut cut;
  double gone = 0;
  std::vector<char> keep(marked.size());
  for (std::size_t f = 0; f < keep.size(); ++f) {
    keep[f] = !marked[f];
    if (keep[f]) continue;
    gone += area_of(mesh, static_cast<Index>(f));
    cut.removed.add(centroid_of(mesh, static_cast<Index>(f)));
  }
  cut.area_share = gone / surface_area(mesh);
  cut.surface = mesh;
  keep_triangles(cut.surface, keep);
  fill_holes(cut.surface, true, ctx);
  drop_unused_vertices(cut.surface);
  split_nonmanifold(cut.surface);
  cut.report = inspect_split(cut.surface, &ctx);
  return cut;
}

}  // namespace

std::optional<Recut> recut_crossings(const TriMesh& mesh, const MeshReport& report, Context& ctx) {
  if (report.self_intersections.count == 0 || report.open_edges.count > 0 ||
      report.self_intersections.count >= MeshReport::kMaxIntersections ||
      crosses_other_shell(mesh, report))
    return std::nullopt;
  const double volume = enclosed_volume(mesh);
  Recut best;
  best.surface = mesh;
  best.report = report;
  int rings = 0;
  for (int round = 0; round < kRounds; ++round) {
    ctx.checkpoint();
    TriMesh welded = best.surface;
    weld_equal_vertices(welded);
    if (welded.triangles.rows() != best.surface.triangles.rows()) return std::nullopt;
    std::vector<char> marked(at(static_cast<Index>(welded.triangles.rows())), 0);
    for (const auto& [f, g] : best.report.intersecting_pairs) marked[at(f)] = marked[at(g)] = 1;
    for (int i = 0; i < rings; ++i) grow(welded, marked);
    mark_islands(welded, surface_area(welded), marked);
    Recut cut = cut_and_close(welded, marked, ctx);
    if (best.area_share + cut.area_share > kMostArea) return std::nullopt;
    const bool better = cut.report.open_edges.count == 0 &&
                        cut.report.self_intersections.count < best.report.self_intersections.count;
    if (!better) {
      ++rings;
      continue;
    }
    cut.area_share += best.area_share;
    for (const Vec3& place : best.removed.where) cut.removed.add(place);
    cut.removed.count += best.removed.count - static_cast<Index>(best.removed.where.size());
    best = std::move(cut);
    rings = std::min(rings + 1, kMostRings);
    if (best.report.valid())
      return std::abs(enclosed_volume(best.surface) - volume) <= kMostVolume * std::abs(volume)
                 ? std::optional<Recut>(std::move(best))
                 : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace s3
