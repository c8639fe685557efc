#include "toolpaths/hole_filler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "toolpaths/point_grid.h"

namespace s3 {
namespace {

class HoleFiller {
 public:
  HoleFiller(const WorkLayer& layer, const Values& coordinate, const MedialAxis& axis, double width)
      : layer_(layer), coordinate_(coordinate), axis_(axis), width_(width), grid_(1) {}

  void fill(std::vector<PlannedPath>& paths) {
    double widest = width_;
    for (const PlannedPath& p : paths) widest = std::max(widest, p.path.width.maxCoeff());
    grid_ = PointGrid(0.5 * widest + kLargestRadius * width_);
    for (const PlannedPath& p : paths) add_points(p.path);
    grid_.finish();
    collect();
    std::sort(holes_.begin(), holes_.end(), [](const Hole& a, const Hole& b) {
      return a.radius != b.radius ? a.radius > b.radius : a.order < b.order;
    });
    std::vector<Hole> filled;
    for (Hole& hole : holes_) {
      for (const Hole& other : filled)
        hole.radius = std::min(hole.radius, (other.point - hole.point).norm() - other.radius);
      if (2 * hole.radius < kLeastBeadWidth * width_) continue;
      filled.push_back(hole);
      paths.push_back(bead(hole));
    }
  }

 private:
  static constexpr double kLargestRadius = 0.6;  // of w
  struct Hole {
    Vec3 point, normal, along;
    double thickness, radius;
    Index vertex, order;
  };

  void add_points(const Path& path) {
    const Eigen::Index n = path.points.rows();
    for (Eigen::Index i = 0; i + 1 < n + (path.closed ? 1 : 0); ++i) {
      const Eigen::Index j = (i + 1) % n;
      const Vec3 a = path.points.row(i), b = path.points.row(j);
      const int pieces = 1 + static_cast<int>((b - a).norm() / (0.2 * width_));
      for (int k = 0; k <= pieces; ++k) {
        const double t = static_cast<double>(k) / pieces;
        grid_.add((1 - t) * a + t * b);
        reach_.push_back(0.5 * ((1 - t) * path.width(i) + t * path.width(j)));
      }
    }
  }

  /// Radius of the largest disc around a point that no bead touches.
  double clearance(const Vec3& p, double boundary_distance) const {
    double radius = std::min(kLargestRadius * width_, boundary_distance);
    grid_.visit(p, [&](Index i) {
      radius = std::min(radius, (grid_.point(i) - p).norm() - reach_[static_cast<std::size_t>(i)]);
    });
    return radius;
  }

  void add(Hole hole, double boundary_distance) {
    hole.radius = clearance(hole.point, boundary_distance);
    if (2 * hole.radius < kLeastBeadWidth * width_) return;
    hole.order = static_cast<Index>(holes_.size());
    holes_.push_back(hole);
  }

  void collect() {
    for (std::size_t i = 0; i < axis_.nodes.size(); ++i) {
      const MedialNode& node = axis_.nodes[i];
      Vec3 along = node.normal.unitOrthogonal();
      if (axis_.graph.begin[i] < axis_.graph.begin[i + 1]) {
        const Index other = axis_.graph.neighbor[static_cast<std::size_t>(axis_.graph.begin[i])];
        const Vec3 way = axis_.nodes[static_cast<std::size_t>(other)].point - node.point;
        if (way.norm() > 1e-9 * width_) along = way.normalized();
      }
      add({node.point, node.normal, along, node.thickness, 0, node.vertex, 0}, node.radius);
    }
    std::vector<char> highest(static_cast<std::size_t>(layer_.mesh.vertices.rows()), 1);
    for (const auto& [a, b] : layer_.edges.ends)
      highest[static_cast<std::size_t>(
          layer_.field.distance(a) < layer_.field.distance(b) ? a : b)] = 0;
    for (Eigen::Index v = 0; v < layer_.mesh.vertices.rows(); ++v) {
      if (!highest[static_cast<std::size_t>(v)] || !std::isfinite(layer_.field.distance(v)))
        continue;
      const Vec3 normal = layer_.mesh.normal.row(v);
      add({layer_.mesh.vertices.row(v), normal, normal.unitOrthogonal(), layer_.mesh.thickness(v),
           0, static_cast<Index>(v), 0},
          layer_.field.distance(v));
    }
  }

  PlannedPath bead(const Hole& hole) const {
    PlannedPath planned;
    planned.level = static_cast<Index>(std::floor(coordinate_(hole.vertex) + 0.5));
    planned.inner_vertex = hole.vertex;
    Path& path = planned.path;
    path.kind = PathKind::gap_fill;
    path.points.resize(2, 3);
    // Long enough to be printed at all; its round ends do the rest.
    path.points.row(0) = hole.point - 0.4 * hole.radius * hole.along;
    path.points.row(1) = hole.point + 0.4 * hole.radius * hole.along;
    path.normals.resize(2, 3);
    path.normals.rowwise() = hole.normal.transpose();
    path.thickness.setConstant(2, hole.thickness);
    path.width.setConstant(2, 2 * hole.radius);
    return planned;
  }

  const WorkLayer& layer_;
  const Values& coordinate_;
  const MedialAxis& axis_;
  double width_;
  PointGrid grid_;
  std::vector<double> reach_;
  std::vector<Hole> holes_;
};

}  // namespace

void fill_holes(const WorkLayer& layer, const Values& coordinate, const MedialAxis& axis,
                double width, std::vector<PlannedPath>& paths) {
  HoleFiller(layer, coordinate, axis, width).fill(paths);
}

}  // namespace s3
