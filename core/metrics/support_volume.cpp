#include "metrics/support_volume.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace s3 {
namespace {

/// The boundary's triangles by the cells of a grid over x and y that they touch: what a vertical
/// ray can meet.
class ColumnGrid {
 public:
  explicit ColumnGrid(const TetMesh& mesh) : mesh_(mesh), box_(bounding_box(mesh.vertices)) {
    const Vec3 size = (box_.max - box_.min).cwiseMax(1e-9);
    const double faces = std::max<double>(1, static_cast<double>(mesh.boundary_faces.rows()));
    cell_ = std::sqrt(size.x() * size.y() / faces);  // about one cell a face
    cell_ = std::max(cell_, std::max(size.x(), size.y()) / 2048);
    columns_ = static_cast<int>(size.x() / cell_) + 1;
    rows_ = static_cast<int>(size.y() / cell_) + 1;
    begin_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
    for_each_cell([&](std::size_t cell, Index) { ++begin_[cell + 1]; });
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    faces_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for_each_cell([&](std::size_t cell, Index f) { faces_[next[cell]++] = f; });
  }

  double floor() const { return box_.min.z(); }
  double diagonal() const { return box_.diagonal(); }

  /// Height of the highest surface below `from`, at least `clearance` below it; the floor where
  /// there is none.
  double surface_below(const Vec3& from, double clearance) const {
    double best = floor();
    const std::size_t cell = cell_of(column(from.x()), row(from.y()));
    for (std::size_t i = begin_[cell]; i < begin_[cell + 1]; ++i) {
      const double z = height_at(faces_[i], from.x(), from.y());
      if (z < from.z() - clearance) best = std::max(best, z);
    }
    return best;
  }

 private:
  int column(double x) const { return clamp((x - box_.min.x()) / cell_, columns_); }
  int row(double y) const { return clamp((y - box_.min.y()) / cell_, rows_); }
  static int clamp(double value, int count) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(count - 1)));
  }
  std::size_t cell_of(int column, int row) const {
    return static_cast<std::size_t>(row) * columns_ + column;
  }
  Vec3 corner(Index f, int i) const { return mesh_.vertices.row(mesh_.boundary_faces(f, i)); }

  template <class Body>
  void for_each_cell(Body&& body) const {
    for (Index f = 0; f < mesh_.boundary_faces.rows(); ++f) {
      const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
      const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
      for (int r = row(low.y()); r <= row(high.y()); ++r)
        for (int k = column(low.x()); k <= column(high.x()); ++k) body(cell_of(k, r), f);
    }
  }

  /// z of the triangle's plane over (x, y); −∞ outside the triangle.
  double height_at(Index f, double x, double y) const {
    const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0) return -HUGE_VAL;
    const double u = ((b.x() - x) * (c.y() - y) - (b.y() - y) * (c.x() - x)) / area;
    const double v = ((c.x() - x) * (a.y() - y) - (c.y() - y) * (a.x() - x)) / area;
    const double w = 1 - u - v;
    if (u < 0 || v < 0 || w < 0) return -HUGE_VAL;
    return u * a.z() + v * b.z() + w * c.z();
  }

  const TetMesh& mesh_;
  Box box_;
  double cell_ = 1;
  int columns_ = 1, rows_ = 1;
  std::vector<std::size_t> begin_;
  std::vector<Index> faces_;
};

/// Mean height of the space under a face, over the centroids of its subdivision into n² triangles.
double mean_drop(const ColumnGrid& grid, const Vec3& a, const Vec3& b, const Vec3& c,
                 double spacing) {
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  constexpr int kMostSplits = 64;
  const int n = std::clamp(static_cast<int>(std::ceil(longest / spacing)), 1, kMostSplits);
  const double clearance =
      1e-6 * grid.diagonal();  // the face itself and its neighbours are no floor
  double sum = 0;
  int samples = 0;
  const auto add = [&](double i, double j) {
    const Vec3 p = a + (b - a) * (i / n) + (c - a) * (j / n);
    sum += p.z() - grid.surface_below(p, clearance);
    ++samples;
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      add(i + 1. / 3, j + 1. / 3);
      if (i + j + 1 < n) add(i + 2. / 3, j + 2. / 3);
    }
  return sum / samples;
}

}  // namespace

double support_volume(const TetMesh& rest, const ObjectiveField& objectives,
                      const Directions& print_direction, Context& ctx) {
  constexpr double kSinOverhang = std::numbers::sqrt2 / 2;
  constexpr double kTolerance = 1e-8;
  const ColumnGrid grid(rest);
  const double spacing = grid.diagonal() / 200;
  constexpr std::size_t kGrain = 1024;
  const auto face_count = static_cast<std::size_t>(rest.boundary_faces.rows());
  return parallel_sum(ctx.pool, face_count, kGrain, 0.0, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    double volume = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto f = static_cast<Eigen::Index>(i);
      const Vec3 n = objectives.face_normal.row(f);
      const Vec3 d = print_direction.row(rest.boundary_face_tet[i]);
      if (objectives.face_exempt[i] || n.z() >= 0 || d.dot(n) >= -kSinOverhang - kTolerance)
        continue;
      const auto corner = [&](int k) -> Vec3 {
        return rest.vertices.row(rest.boundary_faces(f, k));
      };
      const double footprint = -n.z() * objectives.face_area(f);
      volume += footprint * mean_drop(grid, corner(0), corner(1), corner(2), spacing);
    }
    return volume;
  });
}

}  // namespace s3
