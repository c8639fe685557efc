#include "mesh/parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <utility>

#include "mesh/aabb_tree.h"
#include "mesh/exact_predicates.h"

namespace s3 {
namespace {

constexpr double kOnPlate = 1e-3;  // of the height: so near the plate a part stands on it

class Sets {
 public:
  explicit Sets(Index n) : parent_(static_cast<std::size_t>(n)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  Index find(Index i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  /// @return false if they were one already
  bool join(Index a, Index b) {
    a = find(a);
    b = find(b);
    at(std::max(a, b)) = std::min(a, b);
    return a != b;
  }

 private:
  Index& at(Index i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<Index> parent_;
};

Corners corners_of(const TriMesh& mesh, Index f) {
  Corners corners;
  for (int i = 0; i < 3; ++i)
    corners[static_cast<std::size_t>(i)] = mesh.vertices.row(mesh.triangles(f, i));
  return corners;
}

Box box_of(const Corners& c) {
  return {c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2])};
}

/// Pieces that hang together by vertices, numbered by their first triangle.
std::vector<Index> pieces_of(const TriMesh& mesh, Index& count) {
  Sets sets(static_cast<Index>(mesh.vertices.rows()));
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
    for (int i = 1; i < 3; ++i) sets.join(mesh.triangles(f, 0), mesh.triangles(f, i));
  std::vector<Index> number(static_cast<std::size_t>(mesh.vertices.rows()), -1);
  std::vector<Index> piece;
  count = 0;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    Index& known = number[static_cast<std::size_t>(sets.find(mesh.triangles(f, 0)))];
    if (known < 0) known = count++;
    piece.push_back(known);
  }
  return piece;
}

/// The groups around a point, by the parity of crossings along three rays, by majority; ascending.
std::vector<Index> groups_around(const AabbTree& tree, const std::vector<Index>& group,
                                 const Vec3& point) {
  // Directions without any relation to coordinates, so that rays miss edges and corners.
  const std::array<Vec3, 3> directions = {
      Vec3(0.2917, 0.7611, 0.5793), Vec3(-0.6331, 0.2039, 0.7477), Vec3(0.1933, -0.8111, -0.5487)};
  std::vector<std::array<Index, 2>> crossings;  // group, ray
  for (Index ray = 0; ray < 3; ++ray)
    for (const RayHit& hit : tree.all_hits(point, directions[static_cast<std::size_t>(ray)]))
      crossings.push_back({group[static_cast<std::size_t>(hit.triangle)], ray});
  std::sort(crossings.begin(), crossings.end());
  std::vector<Index> around;
  for (std::size_t i = 0; i < crossings.size();) {
    const Index g = crossings[i][0];
    std::array<int, 3> count{};
    for (; i < crossings.size() && crossings[i][0] == g; ++i)
      ++count[static_cast<std::size_t>(crossings[i][1])];
    if (count[0] % 2 + count[1] % 2 + count[2] % 2 >= 2) around.push_back(g);
  }
  return around;
}

void find_meetings(const TriMesh& mesh, const AabbTree& tree, const std::vector<Index>& part,
                   Sets& sets, std::vector<PartContact>& contacts, const Context& ctx) {
  constexpr Index kCheckEvery = 4096;
  std::vector<Index> near;
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    if (f % kCheckEvery == 0) ctx.checkpoint();
    const Corners t = corners_of(mesh, f);
    if (is_degenerate(t)) continue;
    tree.triangles_in_box(box_of(t), near);
    std::sort(near.begin(), near.end());
    const Index own = part[static_cast<std::size_t>(f)];
    for (const Index g : near) {
      const Index other = part[static_cast<std::size_t>(g)];
      if (sets.find(own) == sets.find(other)) continue;
      const Corners s = corners_of(mesh, g);
      if (is_degenerate(s) || !triangles_meet(t, s)) continue;
      sets.join(own, other);
      contacts.push_back({std::min(own, other), std::max(own, other), (t[0] + t[1] + t[2]) / 3});
    }
  }
}

void find_containments(const TriMesh& mesh, const AabbTree& tree, const std::vector<Index>& part,
                       Sets& sets, std::vector<PartContact>& contacts, const Context& ctx) {
  Index pieces = 0;
  const std::vector<Index> piece = pieces_of(mesh, pieces);
  std::vector<char> seen(static_cast<std::size_t>(pieces), 0);
  for (Index f = 0; f < mesh.triangles.rows(); ++f) {
    char& known = seen[static_cast<std::size_t>(piece[static_cast<std::size_t>(f)])];
    if (known) continue;
    known = 1;
    ctx.checkpoint();
    const Index own = part[static_cast<std::size_t>(f)];
    const Vec3 corner = mesh.vertices.row(mesh.triangles(f, 0));
    for (const Index other : groups_around(tree, part, corner))
      if (sets.join(own, other))
        contacts.push_back({std::min(own, other), std::max(own, other), corner});
  }
}

std::string named(const std::vector<std::string>& names, Index part) {
  const std::string& name = names[static_cast<std::size_t>(part)];
  return name.empty() ? "part " + std::to_string(part + 1) : "'" + name + "'";
}

std::string at_place(const Vec3& p) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "(%.4g, %.4g, %.4g)", p.x(), p.y(), p.z());
  return text.data();
}

/// Groups of parts that keep together, numbered by their first part. @return #parts
std::vector<Index> groups_of(const std::vector<PartContact>& contacts, Index parts) {
  Sets sets(parts);
  for (const PartContact& c : contacts) sets.join(c.first, c.second);
  std::vector<Index> group;
  group.reserve(static_cast<std::size_t>(parts));
  for (Index p = 0; p < parts; ++p) group.push_back(sets.find(p));
  return group;
}

void warn_about_merged(const std::vector<PartContact>& contacts,
                       const std::vector<std::string>& names, Context& ctx) {
  if (contacts.empty()) return;
  std::vector<Vec3> places;
  places.reserve(contacts.size());
  for (const PartContact& c : contacts) places.push_back(c.place);
  const PartContact& c = contacts.front();
  std::string text = "The parts " + named(names, c.first) + " and " + named(names, c.second) +
                     " meet near " + at_place(c.place);
  if (contacts.size() > 1) text += ", as do " + std::to_string(contacts.size() - 1) + " more pairs";
  ctx.warn("mesh.merged_parts",
           text +
               "; they are printed as one body: move them apart in your CAD program if they are "
               "to be separate",
           std::move(places));
}

/// How far above the lowest group each one starts, mm; by the group's number.
Values drops_of(const TriMesh& mesh, const std::vector<Index>& group_of_triangle, Index groups,
                const Values& height) {
  Values low = Values::Constant(groups, std::numeric_limits<double>::infinity());
  for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i) {
    double& lowest = low[group_of_triangle[static_cast<std::size_t>(i / 3)]];
    lowest = std::min(lowest, height[mesh.triangles.data()[i]]);
  }
  const double floor = low.minCoeff();
  return (low.array() == std::numeric_limits<double>::infinity()).select(0, low.array() - floor);
}

}  // namespace

std::vector<PartContact> part_contacts(const TriMesh& mesh,
                                       const std::vector<Index>& part_of_triangle, Index parts,
                                       const Context& ctx) {
  std::vector<PartContact> contacts;
  const AabbTree tree(mesh);
  Sets sets(parts);
  find_meetings(mesh, tree, part_of_triangle, sets, contacts, ctx);
  find_containments(mesh, tree, part_of_triangle, sets, contacts, ctx);
  return contacts;
}

InputParams stand_parts(TriMesh& surface, const std::vector<Index>& part_of_triangle,
                        const std::vector<std::string>& part_names, const InputParams& params,
                        std::vector<Orientation>& orientations, Context& ctx) {
  const auto parts = static_cast<Index>(part_names.size());
  const std::vector<PartContact> contacts = part_contacts(surface, part_of_triangle, parts, ctx);
  warn_about_merged(contacts, part_names, ctx);
  const std::vector<Index> group = groups_of(contacts, parts);
  std::vector<Index> group_of_triangle;
  group_of_triangle.reserve(part_of_triangle.size());
  for (const Index part : part_of_triangle)
    group_of_triangle.push_back(group[static_cast<std::size_t>(part)]);

  const Eigen::Affine3d placed =
      placement(surface.vertices, surface.triangles, params, &orientations, &ctx);
  InputParams written = params;
  if (!orientations.empty()) written.rotate = orientations.front().rotate;
  const Values height = surface.vertices * placed.linear().row(2).transpose();
  const Values drop = drops_of(surface, group_of_triangle, parts, height);
  const auto floating = (drop.array() > kOnPlate * (height.maxCoeff() - height.minCoeff())).count();
  if (floating == 0) return written;

  const Vec3 down = placed.linear().inverse() * -Vec3::UnitZ();
  TriMesh moved = surface;
  std::vector<char> done(static_cast<std::size_t>(surface.vertices.rows()), 0);
  for (Eigen::Index i = 0; i < surface.triangles.size(); ++i) {
    const Index v = surface.triangles.data()[i];
    if (std::exchange(done[static_cast<std::size_t>(v)], 1)) continue;
    moved.vertices.row(v) +=
        drop[group_of_triangle[static_cast<std::size_t>(i / 3)]] * down.transpose();
  }
  const std::vector<PartContact> collisions = part_contacts(moved, group_of_triangle, parts, ctx);
  if (!collisions.empty()) {
    const PartContact& c = collisions.front();
    ctx.warn("mesh.parts_collide",
             "Put onto the plate, the parts " + named(part_names, c.first) + " and " +
                 named(part_names, c.second) +
                 " would run into each other; all parts stay where the file has them: move them "
                 "apart in your CAD program",
             {c.place});
    return written;
  }
  ctx.warn("mesh.dropped_parts",
           std::to_string(floating) + " of the file's " + std::to_string(parts) +
               " parts started above the lowest one; each was put onto the plate. Parts that "
               "belong together must touch, or be one object");
  surface = std::move(moved);
  return written;
}

void warn_about_floating_parts(const TriMesh& placed, Context& ctx) {
  Index pieces = 0;
  const std::vector<Index> piece = pieces_of(placed, pieces);
  if (pieces < 2) return;
  const Values start = drops_of(placed, piece, pieces, placed.vertices.col(2));
  const Box box = bounding_box(placed.vertices);
  const double limit = kOnPlate * (box.max.z() - box.min.z());
  const AabbTree tree(placed);
  std::vector<char> seen(static_cast<std::size_t>(pieces), 0);
  std::vector<Vec3> places;
  double highest = 0;
  for (Index f = 0; f < placed.triangles.rows(); ++f) {
    const Index own = piece[static_cast<std::size_t>(f)];
    if (std::exchange(seen[static_cast<std::size_t>(own)], 1) || start[own] <= limit) continue;
    ctx.checkpoint();
    const Vec3 corner = placed.vertices.row(placed.triangles(f, 0));
    std::vector<Index> around = groups_around(tree, piece, corner);
    around.erase(std::remove(around.begin(), around.end(), own), around.end());
    if (around.size() % 2 == 1) continue;  // a cavity
    places.push_back(corner);
    highest = std::max(highest, start[own]);
  }
  if (places.empty()) return;
  std::array<char, 40> gap{};
  std::snprintf(gap.data(), gap.size(), "%.3g", highest);
  ctx.warn("mesh.floating_part",
           std::to_string(places.size()) + (places.size() == 1 ? " body starts" : " bodies start") +
               " up to " + gap.data() + " mm above the plate without touching anything, near " +
               at_place(places.front()) +
               ": support it, lower it to the plate, or join it to what it belongs to",
           places);
}

}  // namespace s3
