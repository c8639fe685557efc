#include "toolpaths/hybrid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/units.h"
#include "toolpaths/direction_field.h"
#include "toolpaths/even_lines.h"
#include "toolpaths/join_stripes.h"
#include "toolpaths/simplify.h"
#include "toolpaths/stripe_pattern.h"
#include "toolpaths/trace_stripes.h"

namespace s3 {
namespace {

constexpr double kLeastInside = 1.0;  // of w: half the width between opposite fences, to hold lines
constexpr double kShortest = 1.0;     // of w: lines shorter than this are left out

/// Pieces of a layer inside of the walls that are wide enough for lines.
struct InfillAreas {
  std::vector<Index> of_vertex;  // #V of WorkLayer::mesh, −1 outside
  std::vector<Index> vertex;     // of each area: one of its vertices

  Index count() const { return static_cast<Index>(vertex.size()); }
};

InfillAreas find_areas(const ContourPlan& plan, double width, int walls) {
  const auto n = static_cast<std::size_t>(plan.work.mesh.vertices.rows());
  const VertexGraph graph = make_vertex_graph(plan.work.edges.ends, static_cast<Index>(n));
  const auto inside = [&](Index v) { return plan.field.coordinate(v) >= walls + 0.5; };
  InfillAreas areas;
  areas.of_vertex.assign(n, -1);
  std::vector<char> seen(n, 0);
  for (Index start = 0; start < static_cast<Index>(n); ++start) {
    if (seen[static_cast<std::size_t>(start)] || !inside(start)) continue;
    std::vector<Index> piece = {start};
    seen[static_cast<std::size_t>(start)] = 1;
    double deepest = 0;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const auto v = static_cast<std::size_t>(piece[i]);
      deepest = std::max(deepest, plan.work.field.distance(piece[i]));
      for (Index k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
        const Index w = graph.neighbor[static_cast<std::size_t>(k)];
        if (seen[static_cast<std::size_t>(w)] || !inside(w)) continue;
        seen[static_cast<std::size_t>(w)] = 1;
        piece.push_back(w);
      }
    }
    if (deepest < (walls + 0.5 + kLeastInside) * width) continue;
    for (const Index v : piece) areas.of_vertex[static_cast<std::size_t>(v)] = areas.count();
    areas.vertex.push_back(start);
  }
  return areas;
}

/// The area of every triangle that touches one, and of those beside them; −1 for all others.
std::vector<Index> areas_of_triangles(const InfillAreas& areas, const SplitTriangles& even) {
  constexpr int kRings = 2;
  std::vector<Index> of_vertex = areas.of_vertex;
  std::vector<Index> of_triangle(even.origin.size(), -1);
  for (int ring = 0; ring < kRings; ++ring) {
    for (Eigen::Index f = 0; f < even.triangles.rows(); ++f)
      for (int k = 0; k < 3 && of_triangle[static_cast<std::size_t>(f)] < 0; ++k)
        of_triangle[static_cast<std::size_t>(f)] =
            of_vertex[static_cast<std::size_t>(even.triangles(f, k))];
    for (Eigen::Index f = 0; f < even.triangles.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (Index& area = of_vertex[static_cast<std::size_t>(even.triangles(f, k))]; area < 0)
          area = of_triangle[static_cast<std::size_t>(f)];
  }
  return of_triangle;
}

/// Beads between the inner edge of the walls and a vertex.
double beads_inside(const StripeMesh& mesh, Eigen::Index v, const WorkLayer& layer, double width,
                    int walls) {
  return layer.field.distance(mesh.work_vertex[static_cast<std::size_t>(v)]) / width - walls;
}

/// Lines that nearly run along a wall should do so exactly: otherwise they leave slivers. Strong
/// enough to bend what the stress hardly defines, too weak to turn lines in S.
LineGuides guide_along_walls(const StripeMesh& mesh, const Directions& line, const WorkLayer& layer,
                             double width, int walls) {
  constexpr double kLargestSine = 0.5;  // between line and wall: 30°
  constexpr double kReach = 2.0;        // of w
  constexpr double kTrust = 2;
  const Eigen::Index n = mesh.vertices.rows();
  LineGuides guides{Values::Zero(n), Directions::Zero(n, 3)};
  for (Eigen::Index v = 0; v < n; ++v) {
    const Vec3 normal = mesh.normal.row(v);
    Vec3 away = layer.field.away.row(mesh.work_vertex[static_cast<std::size_t>(v)]);
    away -= normal * normal.dot(away);
    const double inside = std::max(0.0, beads_inside(mesh, v, layer, width, walls) - 0.5);
    if (!(away.squaredNorm() > 0) || inside >= kReach) continue;
    away.normalize();
    const double sine = std::abs(Vec3(line.row(v)).dot(away));
    if (sine >= kLargestSine) continue;
    guides.trust(v) = kTrust * std::pow(1 - sine / kLargestSine, 3) * (1 - inside / kReach);
    guides.direction.row(v) = normal.cross(away);
  }
  return guides;
}

/// Where lines run along a wall, the first should lie beside it, half a bead from its edge.
StripeAnchors anchor_at_walls(const StripeMesh& mesh, const Directions& line,
                              const WorkLayer& layer, double width, int walls) {
  constexpr double kParallel = 0.3;  // sine of the largest angle between line and wall
  constexpr double kReach = 1.5;     // of w, to both sides of the first line
  constexpr double kWeight = 8.0;
  StripeAnchors anchors{Values::Zero(mesh.vertices.rows()), Values::Zero(mesh.vertices.rows())};
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Index from = mesh.work_vertex[static_cast<std::size_t>(v)];
    const Vec3 away = layer.field.away.row(from);
    const double inside = beads_inside(mesh, v, layer, width, walls);
    const double sine = std::abs(Vec3(line.row(v)).dot(away));
    if (away.squaredNorm() == 0 || sine > kParallel || std::abs(inside - 0.5) > kReach) continue;
    const Vec3 across = Vec3(mesh.normal.row(v)).cross(Vec3(line.row(v)));
    anchors.weight(v) = kWeight * (1 - sine / kParallel) * (1 - std::abs(inside - 0.5) / kReach);
    anchors.phase(v) = (across.dot(away) > 0 ? 2 : -2) * kPi * inside;
  }
  return anchors;
}

/// Stripe lines as paths, cut where they leave the area inside of the walls. A line that runs along
/// a wall may come nearer to it than one that ends there: otherwise it would be cut into crumbs.
class LineCutter {
 public:
  /// @param area  of each triangle of the mesh
  LineCutter(const WorkLayer& layer, const StripeMesh& mesh, const std::vector<Index>& area,
             double width, int walls)
      : layer_(layer), mesh_(mesh), area_(area), width_(width), walls_(walls) {}

  /// @param result  the paths of each area
  void cut(const StripeLine& line, std::vector<std::vector<Path>>& result) const {
    const std::size_t n = line.nodes.size(), pieces = line.triangles.size();
    std::vector<Sample> samples;
    for (const StripeLine::Node& node : line.nodes) samples.push_back(sample(node));
    smooth(samples, line.closed);
    std::vector<char> inside(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t before = i > 0 ? i - 1 : (line.closed ? n - 1 : 0);
      const std::size_t after = i + 1 < n ? i + 1 : (line.closed ? 0 : i);
      inside[i] = is_inside(line.triangles[std::min(i, pieces - 1)], samples[i].point,
                            samples[after].point - samples[before].point);
    }
    const auto outside = std::find(inside.begin(), inside.end(), 0);
    if (outside == inside.end()) {
      result[area_of(line.triangles.front())].push_back(make_path(samples, line.closed));
      return;
    }
    // A closed line is cut open where it is outside.
    const std::size_t start = line.closed ? static_cast<std::size_t>(outside - inside.begin()) : 0;
    std::vector<Sample> current;
    if (inside[start]) current.push_back(samples[start]);
    for (std::size_t step = 0; step < pieces; ++step) {
      const std::size_t i = (start + step) % n, j = (i + 1) % n;
      if (inside[i] != inside[j])
        current.push_back(crossing(line.triangles[i], samples[i], samples[j], inside[i]));
      if (inside[j]) {
        current.push_back(samples[j]);
      } else if (!current.empty()) {
        finish(current, result[area_of(line.triangles[i])]);
      }
    }
    finish(current, result[area_of(line.triangles[(start + pieces - 1) % n])]);
  }

 private:
  struct Sample {
    Vec3 point, normal;
    double thickness = 0;
  };

  std::size_t area_of(Index triangle) const {
    return static_cast<std::size_t>(area_[static_cast<std::size_t>(triangle)]);
  }

  Sample sample(const StripeLine::Node& node) const {
    const auto [a, b] = mesh_.edges.ends[static_cast<std::size_t>(node.edge)];
    const Index va = mesh_.work_vertex[static_cast<std::size_t>(a)],
                vb = mesh_.work_vertex[static_cast<std::size_t>(b)];
    const double t = node.fraction;
    return {(1 - t) * layer_.mesh.vertices.row(va) + t * layer_.mesh.vertices.row(vb),
            ((1 - t) * layer_.mesh.normal.row(va) + t * layer_.mesh.normal.row(vb)).normalized(),
            (1 - t) * layer_.mesh.thickness(va) + t * layer_.mesh.thickness(vb)};
  }

  /// Takes out the corners that a line has at the mesh's edges.
  static void smooth(std::vector<Sample>& samples, bool closed) {
    constexpr int kRounds = 3;
    const std::size_t n = samples.size();
    if (n < 3) return;
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<Sample> old = samples;
      for (std::size_t i = closed ? 0 : 1; i + (closed ? 0 : 1) < n; ++i)
        samples[i].point =
            0.25 * old[(i + n - 1) % n].point + 0.5 * old[i].point + 0.25 * old[(i + 1) % n].point;
    }
  }

  /// The nearest boundary point, as the triangle's corners see it.
  BoundaryHit nearest_boundary(Index triangle, const Vec3& point) const {
    BoundaryHit nearest;
    nearest.distance = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Index v = mesh_.work_vertex[static_cast<std::size_t>(mesh_.triangles(triangle, k))];
      const BoundarySource& source = layer_.field.source[static_cast<std::size_t>(v)];
      if (source.edge < 0) continue;
      const BoundaryHit hit = hit_boundary(layer_.boundary, source, point, true);
      if (hit.distance < nearest.distance) nearest = hit;
    }
    return nearest;
  }

  bool is_inside(Index triangle, const Vec3& point, const Vec3& way) const {
    constexpr double kAlong = 0.2, kAcross = 0.45;  // of w from the walls' inner edge
    constexpr double kSteep = 0.7;                  // sine of the angle to the wall
    const BoundaryHit hit = nearest_boundary(triangle, point);
    const double length = way.norm();
    const double sine = length > 0 ? std::abs(way.dot(hit.away)) / length : 0;
    const double least = kAlong + (kAcross - kAlong) * std::min(1.0, sine / kSteep);
    return hit.distance >= (walls_ + least) * width_;
  }

  Sample crossing(Index triangle, const Sample& a, const Sample& b, bool a_inside) const {
    constexpr int kHalvings = 12;
    double low = 0, high = 1;  // low is on the side of a
    const auto at = [&](double t) {
      return Sample{(1 - t) * a.point + t * b.point,
                    ((1 - t) * a.normal + t * b.normal).normalized(),
                    (1 - t) * a.thickness + t * b.thickness};
    };
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      const bool inside = is_inside(triangle, at(middle).point, b.point - a.point);
      (inside == a_inside ? low : high) = middle;
    }
    return at(0.5 * (low + high));
  }

  Path make_path(const std::vector<Sample>& samples, bool closed) const {
    Path path;
    const auto n = static_cast<Eigen::Index>(samples.size());
    path.closed = closed;
    path.kind = PathKind::infill;
    path.points.resize(n, 3);
    path.normals.resize(n, 3);
    path.thickness.resize(n);
    path.width.setConstant(n, width_);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Sample& from = samples[static_cast<std::size_t>(i)];
      path.points.row(i) = from.point;
      path.normals.row(i) = from.normal;
      path.thickness(i) = from.thickness;
    }
    return path;
  }

  void finish(std::vector<Sample>& samples, std::vector<Path>& result) const {
    double length = 0;
    for (std::size_t i = 1; i < samples.size(); ++i)
      length += (samples[i].point - samples[i - 1].point).norm();
    if (length >= kShortest * width_) result.push_back(make_path(samples, false));
    samples.clear();
  }

  const WorkLayer& layer_;
  const StripeMesh& mesh_;
  const std::vector<Index>& area_;
  double width_;
  int walls_;
};

}  // namespace

void fill_with_lines(const LayerStress& stress, double width, int walls, ContourPlan& plan,
                     const Context& ctx) {
  const InfillAreas areas = find_areas(plan, width, walls);
  std::vector<PlannedPath> kept;
  std::vector<std::vector<Path>> fences(areas.vertex.size()), lines(areas.vertex.size());
  bool any = false;
  for (PlannedPath& p : plan.paths) {
    const Index area = areas.of_vertex[static_cast<std::size_t>(p.inner_vertex)];
    if (p.level < walls || area < 0) {
      kept.push_back(std::move(p));
      continue;
    }
    any = true;
    if (p.level == walls && p.path.kind == PathKind::wall)
      fences[static_cast<std::size_t>(area)].push_back(std::move(p.path));
  }
  plan.paths = std::move(kept);
  if (!any) return;

  std::vector<Index> area_of_triangle = areas_of_triangles(areas, plan.work.even);
  std::vector<char> keep(area_of_triangle.size());
  for (std::size_t f = 0; f < keep.size(); ++f) keep[f] = area_of_triangle[f] >= 0;
  const StripeMesh mesh = make_stripe_mesh(plan.work, keep);
  std::erase(area_of_triangle, -1);  // those of the mesh are left
  const Eigen::Index n = mesh.vertices.rows();
  Directions field =
      direction_field(mesh, stress, {Values::Zero(n), Directions::Zero(n, 3)}, {}, width, ctx);
  field = direction_field(mesh, stress, guide_along_walls(mesh, field, plan.work, width, walls),
                          field, width, ctx);
  const StripeAnchors anchors = anchor_at_walls(mesh, field, plan.work, width, walls);
  const StripePattern pattern = stripe_pattern(mesh, field, anchors, width, ctx);
  const LineCutter cutter(plan.work, mesh, area_of_triangle, width, walls);
  for (const StripeLine& line : trace_stripes(mesh, pattern)) cutter.cut(line, lines);
  even_out(plan.paths, width, lines);
  // Area by area: what is printed next is what lies inside of the walls just laid.
  for (std::size_t area = 0; area < lines.size(); ++area)
    for (Path& path : join_stripes(lines[area], fences[area], width)) {
      simplify(path, kSimplifyPath * width);
      plan.paths.push_back({std::move(path), static_cast<Index>(walls), areas.vertex[area]});
    }
}

}  // namespace s3
