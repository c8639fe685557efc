// Each sweep moves all points of all lines at once, by half of what would even out the two gaps
// beside it, and smooths the move along the line. Who lies beside whom is found once, at the start.
// In the end each bead becomes as wide as its gaps ask for.
#include "toolpaths/even_lines.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "toolpaths/point_grid.h"

namespace s3 {
namespace {

constexpr int kSweeps = 6;
constexpr double kStep = 0.5;
constexpr double kSmooth = 0.6;     // of w: the move is a mean over this length to both sides
constexpr double kMost = 0.4;       // of w
constexpr double kFarthest = 0.7;   // of w: gaps that differ more from w do not pull
constexpr double kWider = 0.15;     // of w: a bead's width differs from w by at most this
constexpr double kPiece = 0.5;      // of w: strands are searched in pieces of this length
constexpr double kBeside = 0.7071;  // cosine of the largest angle between strands side by side
constexpr double kSteep = 0.5;      // rise of the way to a strand beside: more is another place
constexpr double kRounding = 1e-9;  // of w: a strand may have its corner exactly across

struct Piece {
  const Path* path;
  Eigen::Index first, last;  // points of the path
  Index first_node;          // node of the path's first point; −1 for what is fixed
  double from, to;           // fractions of the way from the first point to the last
  Vec3 a, along;
};

/// The strand beside a node on one side.
struct Beside {
  double gap = 0;               // mm before any move; 0 for none
  double height = 0;            // mm over the node's tangent plane
  double turn = 0;              // ±1: moves the same way or against
  Index first = -1, last = -1;  // nodes of it; −1 for what is fixed
  double fraction = 0;          // between them
  Vec3 normal = Vec3::Zero();
  double thickness = 0;
};

/// A point of a line.
struct Node {
  Vec3 point, normal, across;
  double length;                 // mm of the line
  std::array<Beside, 2> beside;  // along `across`, and against it
};

class Evener {
 public:
  Evener(const std::vector<PlannedPath>& fixed, double width, std::vector<std::vector<Path>>& lines)
      : width_(width),
        reach_((1 + kFarthest) * width),
        grid_(std::hypot(1, kSteep) * reach_ + 0.5 * kPiece * width) {
    for (std::vector<Path>& area : lines)
      for (Path& path : area) add_line(path);
    for (const PlannedPath& p : fixed) add_pieces(p.path, -1);
    grid_.finish();
    for (std::size_t i = 0; i < nodes_.size(); ++i) find_beside(static_cast<Index>(i));
    shift_ = Values::Zero(static_cast<Eigen::Index>(nodes_.size()));
  }

  void sweep() {
    Values next = shift_;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double pulled = shift_(row) + kStep * (pull(row, 0) - pull(row, 1));
      next(row) = std::clamp(pulled, -kMost * width_, kMost * width_);
    }
    shift_ = smoothed(next);
  }

  void finish() const {
    Values width(shift_.size());
    for (Eigen::Index i = 0; i < width.size(); ++i)
      width(i) = width_ +
                 std::clamp(0.5 * (excess(i, 0) + excess(i, 1)), -kWider * width_, kWider * width_);
    width = smoothed(width);
    for (const Line& line : lines_) {
      const Eigen::Index n = line.path->points.rows();
      for (Eigen::Index i = 0; i < n; ++i)
        move(nodes_[static_cast<std::size_t>(line.first + i)], shift_(line.first + i), *line.path,
             i);
      line.path->width = width.segment(line.first, n);
    }
  }

 private:
  struct Line {
    Path* path;
    Index first;  // node
  };

  void add_line(Path& path) {
    const Eigen::Index n = path.points.rows();
    const auto first = static_cast<Index>(nodes_.size());
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index before = i > 0 ? i - 1 : (path.closed ? n - 1 : 0);
      const Eigen::Index after = i + 1 < n ? i + 1 : (path.closed ? 0 : i);
      const Vec3 point = path.points.row(i), normal = path.normals.row(i);
      const Vec3 ahead = Vec3(path.points.row(after)) - point,
                 behind = point - Vec3(path.points.row(before));
      nodes_.push_back({point,
                        normal,
                        normal.cross(ahead + behind).normalized(),
                        0.5 * (ahead.norm() + behind.norm()),
                        {}});
    }
    lines_.push_back({&path, first});
    add_pieces(path, first);
  }

  void add_pieces(const Path& path, Index first_node) {
    const Eigen::Index n = path.points.rows();
    for (Eigen::Index i = 0; i + 1 < n + (path.closed ? 1 : 0); ++i) {
      const Eigen::Index j = (i + 1) % n;
      const Vec3 a = path.points.row(i), along = Vec3(path.points.row(j)) - a;
      const int count = 1 + static_cast<int>(along.norm() / (kPiece * width_));
      for (int k = 0; k < count; ++k) {
        const double from = static_cast<double>(k) / count, to = (k + 1.0) / count;
        pieces_.push_back({&path, i, j, first_node, from, to, a + along * from, along / count});
        grid_.add(a + along * (0.5 * (from + to)));
      }
    }
  }

  void find_beside(Index i) {
    Node& node = nodes_[static_cast<std::size_t>(i)];
    const Vec3 tangent = node.across.cross(node.normal);
    const double rounding = kRounding * width_;
    std::array<double, 2> nearest = {reach_, reach_};
    std::array<const Piece*, 2> found = {nullptr, nullptr};
    std::array<double, 2> place = {0, 0};
    grid_.visit(node.point, [&](Index k) {
      const Piece& piece = pieces_[static_cast<std::size_t>(k)];
      if (piece.first_node >= 0 &&
          (piece.first_node + piece.first == i || piece.first_node + piece.last == i))
        return;
      const double a = (piece.a - node.point).dot(tangent), b = a + piece.along.dot(tangent);
      if (std::min(a, b) > rounding || std::max(a, b) < -rounding || a == b) return;
      const double t = std::clamp(a / (a - b), 0.0, 1.0);
      const Vec3 way = piece.a + t * piece.along - node.point;
      const double ahead = way.dot(node.across), gap = std::abs(ahead);
      const std::size_t side = ahead > 0 ? 0 : 1;
      if (gap >= nearest[side] || std::abs(way.dot(node.normal)) > kSteep * gap) return;
      nearest[side] = gap;
      found[side] = &piece;
      place[side] = t;
    });
    for (std::size_t side = 0; side < 2; ++side)
      if (found[side] &&
          std::abs(found[side]->along.dot(tangent)) >= kBeside * found[side]->along.norm())
        node.beside[side] = beside(node, *found[side], place[side], nearest[side]);
  }

  Beside beside(const Node& node, const Piece& piece, double place, double gap) const {
    Beside result;
    result.gap = gap;
    result.height = (piece.a + place * piece.along - node.point).dot(node.normal);
    result.fraction = piece.from + place * (piece.to - piece.from);
    const double t = result.fraction;
    const Path& path = *piece.path;
    result.normal = (1 - t) * path.normals.row(piece.first) + t * path.normals.row(piece.last);
    result.thickness = (1 - t) * path.thickness(piece.first) + t * path.thickness(piece.last);
    if (piece.first_node < 0) return result;
    result.first = piece.first_node + static_cast<Index>(piece.first);
    result.last = piece.first_node + static_cast<Index>(piece.last);
    result.turn =
        nodes_[static_cast<std::size_t>(result.first)].across.dot(node.across) > 0 ? 1 : -1;
    return result;
  }

  /// By how much the gap on one side is wider than w, mm; 0 without a strand.
  double excess(Eigen::Index i, std::size_t side) const {
    const Beside& b = nodes_[static_cast<std::size_t>(i)].beside[side];
    if (b.gap == 0) return 0;
    const double there =
        b.first < 0 ? 0
                    : b.turn * ((1 - b.fraction) * shift_(b.first) + b.fraction * shift_(b.last));
    return b.gap + (side == 0 ? 1 : -1) * (there - shift_(i)) - width_;
  }

  /// How far a gap pulls its node over, mm: less than its excess where that is large.
  double pull(Eigen::Index i, std::size_t side) const {
    const double excess_here = excess(i, side), share = excess_here / (kFarthest * width_);
    const double fade = std::max(0.0, 1 - share * share);
    return excess_here * fade * fade;
  }

  /// Means along the lines, weighted by their length and falling with the distance.
  Values smoothed(const Values& values) const {
    Values result(values.size());
    for (const Line& line : lines_) smooth(line, values, result);
    return result;
  }

  void smooth(const Line& line, const Values& values, Values& result) const {
    const double reach = kSmooth * width_;
    const Points& points = line.path->points;
    const Eigen::Index n = points.rows();
    for (Eigen::Index i = 0; i < n; ++i) {
      double weight = 0, sum = 0;
      const auto add = [&](Eigen::Index k, double distance) {
        const Eigen::Index node = line.first + k;
        const double w = nodes_[static_cast<std::size_t>(node)].length * (1 - distance / reach);
        weight += w;
        sum += w * values(node);
      };
      add(i, 0);
      for (const Eigen::Index way : {1, -1}) {
        double distance = 0;
        for (Eigen::Index j = i, k = i + way;; j = k, k += way) {
          if (line.path->closed) k = (k + n) % n;
          if (k < 0 || k >= n || k == i) break;
          distance += (points.row(k) - points.row(j)).norm();
          if (distance >= reach) break;
          add(k, distance);
        }
      }
      result(line.first + i) = weight > 0 ? sum / weight : values(line.first + i);
    }
  }

  /// On the parabola through the node and the strand beside it.
  static void move(const Node& node, double shift, Path& path, Eigen::Index i) {
    path.points.row(i) += shift * node.across.transpose();
    const Beside& b = node.beside[shift > 0 ? 0 : 1];
    if (b.gap == 0) return;
    const double share = std::abs(shift) / b.gap;
    path.points.row(i) += share * share * b.height * node.normal.transpose();
    path.normals.row(i) = ((1 - share) * node.normal + share * b.normal).normalized();
    path.thickness(i) += share * (b.thickness - path.thickness(i));
  }

  double width_, reach_;
  PointGrid grid_;  // middles of pieces
  std::vector<Piece> pieces_;
  std::vector<Node> nodes_;
  std::vector<Line> lines_;
  Values shift_;  // of each node along its `across`, mm
};

}  // namespace

void even_out(const std::vector<PlannedPath>& fixed, double width,
              std::vector<std::vector<Path>>& lines) {
  Evener evener(fixed, width, lines);
  for (int k = 0; k < kSweeps; ++k) evener.sweep();
  evener.finish();
}

}  // namespace s3
