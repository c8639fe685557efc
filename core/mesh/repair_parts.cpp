#include "mesh/repair_parts.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/error.h"
#include "mesh/stitch.h"
#include "mesh/surface_edges.h"

namespace s3 {

namespace {

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

bool is_closed(TriMesh part) {
  weld_equal_vertices(part);
  bool closed = part.triangles.rows() > 0;
  for_each_edge(sorted_sides(part), [&](std::size_t begin, std::size_t end) {
    closed = closed && (end - begin) % 2 == 0;
  });
  return closed;
}

// The triangles of each part, with the vertices that they use.
std::vector<TriMesh> split_into_parts(const TriMesh& surface, const std::vector<Index>& part) {
  const Index count = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  std::vector<std::vector<Index>> triangles(at(count));
  for (std::size_t f = 0; f < part.size(); ++f)
    triangles[at(part[f])].push_back(static_cast<Index>(f));
  std::vector<Index> number(at(static_cast<Index>(surface.vertices.rows())), -1), used;
  std::vector<TriMesh> parts;
  for (const auto& list : triangles) {
    TriMesh mesh;
    mesh.triangles.resize(static_cast<Eigen::Index>(list.size()), 3);
    used.clear();
    for (std::size_t f = 0; f < list.size(); ++f)
      for (int i = 0; i < 3; ++i) {
        const Index v = surface.triangles(list[f], i);
        if (number[at(v)] < 0) {
          number[at(v)] = static_cast<Index>(used.size());
          used.push_back(v);
        }
        mesh.triangles(static_cast<Eigen::Index>(f), i) = number[at(v)];
      }
    mesh.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
    for (std::size_t v = 0; v < used.size(); ++v) {
      mesh.vertices.row(static_cast<Eigen::Index>(v)) = surface.vertices.row(used[v]);
      number[at(used[v])] = -1;
    }
    parts.push_back(std::move(mesh));
  }
  return parts;
}

void append(TriMesh& to, const TriMesh& more) {
  const Eigen::Index vertices = to.vertices.rows(), triangles = to.triangles.rows();
  to.vertices.conservativeResize(vertices + more.vertices.rows(), 3);
  to.vertices.bottomRows(more.vertices.rows()) = more.vertices;
  to.triangles.conservativeResize(triangles + more.triangles.rows(), 3);
  to.triangles.bottomRows(more.triangles.rows()) =
      (more.triangles.array() + static_cast<Index>(vertices)).matrix();
}

// Closed parts, and all others together as one.
std::vector<TriMesh> bodies_of(const TriMesh& surface, const std::vector<Index>& part) {
  std::vector<TriMesh> bodies;
  TriMesh others;
  for (TriMesh& mesh : split_into_parts(surface, part)) {
    if (mesh.triangles.rows() == 0) continue;
    if (is_closed(mesh))
      bodies.push_back(std::move(mesh));
    else
      append(others, mesh);
  }
  if (others.triangles.rows() > 0) bodies.push_back(std::move(others));
  return bodies;
}

bool makes_cavities(const RepairResult& result) {
  return std::any_of(result.changes.begin(), result.changes.end(),
                     [](const RepairChange& c) { return c.code == "repair.cavities"; });
}

// All bodies together: apart, they are valid; touching in whole faces, they may become one;
// everything else is for the winding number.
void judge_together(RepairResult& all, Context& ctx) {
  all.report = inspect_surface(all.surface, &ctx);
  if (all.report.valid()) return;
  if (all.reason.empty() && all.report.self_intersections.count > 0) {
    const std::size_t warnings = ctx.warnings.size();
    RepairResult joined = repair_surface(all.surface, ctx);
    if (joined.valid && !makes_cavities(joined)) {
      joined.changes.insert(joined.changes.begin(), all.changes.begin(), all.changes.end());
      all = std::move(joined);
      return;
    }
    ctx.warnings.resize(warnings);
    all.reason = "parts overlap or touch";
  }
  if (all.reason.empty()) all.reason = "a part lies inside another";
  all.valid = false;
}

}  // namespace

RepairResult repair_parts(const TriMesh& surface, const std::vector<Index>& part_of_triangle,
                          Context& ctx) {
  std::vector<TriMesh> bodies = bodies_of(surface, part_of_triangle);
  if (bodies.size() < 2) return repair_surface(surface, ctx);
  RepairResult all;
  std::optional<Error> refused;
  for (TriMesh& body : bodies) {
    const Index triangles = static_cast<Index>(body.triangles.rows());
    const Vec3 place = body.vertices.row(0);
    try {
      RepairResult one = repair_surface(std::move(body), ctx);
      append(all.surface, one.surface);
      all.changes.insert(all.changes.end(), one.changes.begin(), one.changes.end());
      if (all.reason.empty()) all.reason = one.reason;
    } catch (const Error& error) {  // nothing of it encloses anything: another part may
      refused = error;
      const std::string sentence =
          "A part of " + std::to_string(triangles) + " triangles that encloses nothing left out";
      all.changes.push_back({"repair.flat_parts", sentence, 1, {place}});
      ctx.warn("mesh.part_left_out", sentence + ": " + error.what(), {place});
    }
  }
  if (all.surface.triangles.rows() == 0) throw Error(*refused);
  all.valid = all.reason.empty();
  judge_together(all, ctx);
  return all;
}

}  // namespace s3
