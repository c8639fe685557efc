#include "toolpaths/line_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "base/units.h"
#include "toolpaths/point_grid.h"

namespace s3 {
namespace {

constexpr double kSampleDistance = 1.0;  // of w
constexpr double kPiece = 0.5;           // of w: paths are searched in pieces of this length
constexpr double kSearch = 2.0;          // of w: strands farther away are none
constexpr double kBeside = 0.70710678;   // cosine of the largest angle between strands side by side

struct Piece {
  Vec3 a, along;
  bool infill;
};

struct Foot {
  const Piece* piece = nullptr;
  Vec3 point = Vec3::Zero();
  double squared = std::numeric_limits<double>::infinity();
};

Foot nearest_foot(const Vec3& p, const std::vector<const Piece*>& near) {
  Foot best;
  for (const Piece* piece : near) {
    const double length2 = piece->along.squaredNorm();
    const double t =
        length2 > 0 ? std::clamp((p - piece->a).dot(piece->along) / length2, 0.0, 1.0) : 0.0;
    const Vec3 point = piece->a + t * piece->along;
    const double squared = (p - point).squaredNorm();
    if (squared < best.squared) best = {piece, point, squared};
  }
  return best;
}

struct Strand {
  double distance;  // mm, ahead of the sample
  bool beside;      // runs along the strand that the sample belongs to
};

/// The next strand in a direction across a tangent; nothing within the search distance.
std::optional<Strand> next_strand(const Vec3& p, const Vec3& direction, const Vec3& tangent,
                                  const Piece* except, double farthest,
                                  const std::vector<const Piece*>& near) {
  double nearest = farthest;
  const Piece* found = nullptr;
  for (const Piece* piece : near) {
    if (piece == except) continue;
    const double a = (piece->a - p).dot(tangent), b = a + piece->along.dot(tangent);
    if ((a > 0) == (b > 0)) continue;
    const double t = a / (a - b), ahead = (piece->a + t * piece->along - p).dot(direction);
    if (ahead <= 0 || ahead >= nearest) continue;
    nearest = ahead;
    found = piece;
  }
  if (!found) return std::nullopt;
  return Strand{nearest, std::abs(found->along.dot(tangent)) >= kBeside * found->along.norm()};
}

class Pieces {
 public:
  Pieces(const std::vector<Path>& paths, double width, double reach) : grid_(reach) {
    for (const Path& path : paths) {
      const Eigen::Index n = path.points.rows();
      for (Eigen::Index i = 0; i + 1 < n + (path.closed ? 1 : 0); ++i) {
        const Vec3 a = path.points.row(i), along = Vec3(path.points.row((i + 1) % n)) - a;
        const int count = 1 + static_cast<int>(along.norm() / (kPiece * width));
        for (int k = 0; k < count; ++k) {
          pieces_.push_back({a + along * k / count, along / count, path.kind == PathKind::infill});
          grid_.add(pieces_.back().a + 0.5 * pieces_.back().along);
        }
      }
    }
    grid_.finish();
  }

  void near(const Vec3& place, double distance, std::vector<const Piece*>& result) const {
    std::vector<Index> found;
    grid_.visit(place, [&](Index i) {
      if ((grid_.point(i) - place).squaredNorm() <= distance * distance) found.push_back(i);
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    result.clear();
    for (const Index i : found) result.push_back(&pieces_[static_cast<std::size_t>(i)]);
  }

 private:
  PointGrid grid_;
  std::vector<Piece> pieces_;
};

void add_sample(const Vec3& p, const Vec3& normal, const Vec3* tau, double area, double width,
                const std::vector<const Piece*>& near, LineQuality& result) {
  const Foot foot = nearest_foot(p, near);
  if (!foot.piece || !foot.piece->infill || foot.squared > width * width) return;
  const Vec3 flat = foot.piece->along - normal * normal.dot(foot.piece->along);
  if (!(flat.squaredNorm() > 0)) return;
  const Vec3 tangent = flat.normalized();
  if (tau)
    result.deviation.add(std::acos(std::min(1.0, std::abs(tangent.dot(*tau)))) / (0.5 * kPi), area);
  const Vec3 across = normal.cross(tangent);
  const double offset = (p - foot.point).dot(across);
  const auto next = next_strand(p, offset < 0 ? Vec3(-across) : across, tangent, foot.piece,
                                kSearch * width, near);
  const bool beside = next && next->beside;
  // Within a turn, and where a line runs into a wall, there is no strand across.
  if (!beside && foot.squared <= 0.25 * width * width) return;
  const double spacing = beside ? std::abs(offset) + next->distance : kSearch * width;
  result.spacing.add(spacing / (kSearch * width), area);
}

}  // namespace

LineQuality measure_lines(const LayerMesh& layer, const LayerStress& stress,
                          const std::vector<Path>& paths, double width, const Context& ctx) {
  LineQuality result;
  const double reach = (kSearch + 0.5 * kPiece) * width;
  const Pieces pieces(paths, width, reach + longest_edge(layer) / std::sqrt(3.0));
  std::vector<const Piece*> near;
  for (Eigen::Index f = 0; f < layer.triangles.rows(); ++f) {
    if (f % 1024 == 0) ctx.checkpoint();
    const Vec3 a = layer.vertices.row(layer.triangles(f, 0));
    const Vec3 ab = Vec3(layer.vertices.row(layer.triangles(f, 1))) - a;
    const Vec3 ac = Vec3(layer.vertices.row(layer.triangles(f, 2))) - a;
    const Vec3 cross = ab.cross(ac);
    if (!(cross.squaredNorm() > 0)) continue;
    const Vec3 normal = cross.normalized();
    const Vec3 middle = a + (ab + ac) / 3;
    const double longest =
        std::sqrt(std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()}));
    pieces.near(middle, reach + longest / std::sqrt(3.0), near);
    const int m = std::max(1, static_cast<int>(std::ceil(longest / (kSampleDistance * width))));
    const double part = 0.5 * cross.norm() / (m * m);
    const Vec3 tau = stress.direction.row(f);
    const bool follows = stress.critical[static_cast<std::size_t>(f)] && tau.squaredNorm() > 0;
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < 2 * (m - i) - 1; ++j) {
        // Centre of small triangle j in row i of the subdivision.
        const double third = (j % 2 == 0 ? 1.0 : 2.0) / 3;
        const int column = j / 2;
        const Vec3 p = a + (column + third) / m * ab + (i + third) / m * ac;
        add_sample(p, normal, follows ? &tau : nullptr, part, width, near, result);
      }
  }
  return result;
}

}  // namespace s3
