#include "fea/rigid_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include "base/error.h"
#include "mesh/surface_edges.h"

namespace s3 {
namespace {

// A motion of the unit-sized body counts as free when no constraint resists it by more than this.
constexpr double kFree = 1e-9;
// Components below this share of a direction's largest are written as zero.
constexpr double kSmall = 1e-6;
constexpr std::size_t kMostPieces = 64;  // that hang together by edges or corners

/// Face-connected pieces of one body, and the vertices each of them touches.
struct Body {
  std::vector<std::vector<Index>> pieces;  // vertices, ascending
};

std::vector<Body> bodies_of(const TetMesh& mesh) {
  DisjointSets by_face(static_cast<std::size_t>(mesh.tet_count()));
  for (Eigen::Index f = 0; f < mesh.face_pairs.rows(); ++f)
    by_face.join(mesh.face_pairs(f, 0), mesh.face_pairs(f, 1));
  DisjointSets by_vertex(static_cast<std::size_t>(mesh.tet_count()));
  std::vector<Index> first_tet(static_cast<std::size_t>(mesh.vertex_count()), -1);
  for (Index t = 0; t < mesh.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) {
      Index& first = first_tet[mesh.tets(t, i)];
      if (first < 0) first = t;
      by_vertex.join(first, t);
    }
  // Roots are the lowest tets, so bodies and pieces come in the order of their first tets.
  std::vector<Index> body_at(static_cast<std::size_t>(mesh.tet_count()), -1), piece_at = body_at;
  std::vector<Body> bodies;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    const Index body_root = by_vertex.find(t), piece_root = by_face.find(t);
    if (body_at[body_root] < 0) {
      body_at[body_root] = static_cast<Index>(bodies.size());
      bodies.emplace_back();
    }
    Body& body = bodies[body_at[body_root]];
    if (piece_at[piece_root] < 0) {
      piece_at[piece_root] = static_cast<Index>(body.pieces.size());
      body.pieces.emplace_back();
    }
    for (int i = 0; i < 4; ++i) body.pieces[piece_at[piece_root]].push_back(mesh.tets(t, i));
  }
  for (Body& body : bodies)
    for (std::vector<Index>& piece : body.pieces) {
      std::sort(piece.begin(), piece.end());
      piece.erase(std::unique(piece.begin(), piece.end()), piece.end());
    }
  return bodies;
}

/// u_a at p (from the centre, in body sizes) as a linear function of the translation and the turn.
Vec3 turn_row(const Vec3& p, int axis) {
  return p.cross(Vec3::Unit(axis));  // e_a · (ω × p) = ω · (p × e_a)
}

std::string vector_text(const Vec3& v) {
  std::array<char, 96> text;
  std::snprintf(text.data(), text.size(), "(%.3g, %.3g, %.3g)", v.x(), v.y(), v.z());
  return text.data();
}

std::string axis_text(Vec3 direction) {
  const double largest = direction.cwiseAbs().maxCoeff();
  for (int a = 0; a < 3; ++a)
    if (std::abs(direction[a]) < kSmall * largest) direction[a] = 0;
  for (int a = 0; a < 3; ++a)
    if (direction.cwiseAbs().sum() == std::abs(direction[a])) return std::string(1, "xyz"[a]);
  return vector_text(direction / largest);
}

/// Reduced row echelon form over the first three columns: rows that name axes where they can.
/// @return how many rows keep something in them; they come first
Eigen::Index reduce(Eigen::MatrixXd& rows) {
  Eigen::Index rank = 0;
  for (Eigen::Index c = 0; c < 3 && rank < rows.rows(); ++c) {
    Eigen::Index pivot = rank;
    const double largest = rows.col(c).tail(rows.rows() - rank).cwiseAbs().maxCoeff(&pivot);
    if (largest < kSmall) continue;
    rows.row(rank).swap(rows.row(rank + pivot));
    rows.row(rank) /= rows(rank, c);
    for (Eigen::Index r = 0; r < rows.rows(); ++r)
      if (r != rank) rows.row(r) -= rows(r, c) * rows.row(rank);
    ++rank;
  }
  return rank;
}

/// @param motions  orthonormal columns of translation and turn (6×k) in body sizes
std::vector<std::string> describe(const Eigen::MatrixXd& motions, const Vec3& center, double size) {
  std::vector<std::string> texts;
  if (motions.cols() == 6) return {"move and turn in every way"};
  Eigen::MatrixXd rows(motions.cols(), 6);  // turn first, then translation
  rows << motions.bottomRows(3).transpose(), motions.topRows(3).transpose();
  const Eigen::Index turns = reduce(rows);
  Eigen::MatrixXd slides = rows.bottomRows(rows.rows() - turns).rightCols(3);
  reduce(slides);
  for (Eigen::Index r = 0; r < slides.rows(); ++r)
    texts.push_back("slide along " + axis_text(slides.row(r).transpose()));
  for (Eigen::Index r = 0; r < turns; ++r) {
    const Vec3 turn = rows.row(r).head<3>().transpose(), shift = rows.row(r).tail<3>().transpose();
    std::string text = "turn about " + axis_text(turn);
    if (slides.rows() == 0) {  // else the axis may pass anywhere
      Vec3 point = center + size * turn.cross(shift) / turn.squaredNorm();
      for (double& x : point)
        if (std::abs(x) < kSmall * size) x = 0;
      text.append(" through ").append(vector_text(point));
    }
    texts.push_back(std::move(text));
  }
  return texts;
}

/// A hinge or a piece's own motion: what the whole body does not do.
std::string describe_loose_piece(const TetMesh& mesh, const std::vector<Index>& piece) {
  Vec3 center = Vec3::Zero();
  for (const Index v : piece) center += mesh.vertices.row(v).transpose();
  return "move in the piece around " + vector_text(center / static_cast<double>(piece.size())) +
         ", which shares no face with the rest";
}

class BodyMotion {
 public:
  BodyMotion(const TetMesh& mesh, const Body& body) : mesh_(mesh), body_(body) {
    const auto unknowns = static_cast<Eigen::Index>(6 * body.pieces.size());
    resistance_ = Eigen::MatrixXd::Zero(unknowns, unknowns);
    Vec3 low = Vec3::Constant(1e300), high = -low;
    for (const std::vector<Index>& piece : body.pieces)
      for (const Index v : piece) {
        low = low.cwiseMin(mesh.vertices.row(v).transpose());
        high = high.cwiseMax(mesh.vertices.row(v).transpose());
      }
    center_ = 0.5 * (low + high);
    size_ = 0.5 * (high - low).norm();
  }

  std::vector<std::string> free_motions(const std::vector<std::uint8_t>& held) {
    for (std::size_t k = 0; k < body_.pieces.size(); ++k)
      for (const Index v : body_.pieces[k])
        for (int axis = 0; axis < 3; ++axis)
          if (held[v] >> axis & 1) resist(v, axis, k, k);
    join_pieces();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(resistance_);
    Eigen::Index free = 0;
    while (free < eigen.eigenvalues().size() && eigen.eigenvalues()[free] < kFree) ++free;
    if (free == 0) return {};
    const Eigen::MatrixXd motions = eigen.eigenvectors().leftCols(free);
    if (body_.pieces.size() == 1) return describe(motions, center_, size_);
    Eigen::Index most = 0;  // the piece that moves most in any of them
    Eigen::VectorXd moved(static_cast<Eigen::Index>(body_.pieces.size()));
    for (Eigen::Index k = 0; k < moved.size(); ++k) moved[k] = motions.middleRows(6 * k, 6).norm();
    moved.maxCoeff(&most);
    return {describe_loose_piece(mesh_, body_.pieces[static_cast<std::size_t>(most)])};
  }

 private:
  /// Adds (u_axis of piece a − u_axis of piece b at v)²; a == b stands for a fixed point.
  void resist(Index v, int axis, std::size_t a, std::size_t b) {
    const Vec3 p = (mesh_.vertices.row(v).transpose() - center_) / size_;
    Eigen::Matrix<double, 6, 1> row;
    row << Vec3::Unit(axis), turn_row(p, axis);
    const Eigen::Matrix<double, 6, 6> square = row * row.transpose();
    const auto i = static_cast<Eigen::Index>(6 * a), j = static_cast<Eigen::Index>(6 * b);
    resistance_.block<6, 6>(i, i) += square;
    if (a == b) return;
    resistance_.block<6, 6>(j, j) += square;
    resistance_.block<6, 6>(i, j) -= square;
    resistance_.block<6, 6>(j, i) -= square;
  }

  void join_pieces() {
    if (body_.pieces.size() == 1) return;
    std::vector<std::int32_t> piece_of(static_cast<std::size_t>(mesh_.vertex_count()), -1);
    for (std::size_t k = 0; k < body_.pieces.size(); ++k)
      for (const Index v : body_.pieces[k]) {
        if (piece_of[v] >= 0)
          for (int axis = 0; axis < 3; ++axis)
            resist(v, axis, static_cast<std::size_t>(piece_of[v]), k);
        piece_of[v] = static_cast<std::int32_t>(k);
      }
  }

  const TetMesh& mesh_;
  const Body& body_;
  Vec3 center_;
  double size_ = 1;
  Eigen::MatrixXd resistance_;
};

}  // namespace

std::vector<std::string> free_motions(const TetMesh& mesh, const std::vector<std::uint8_t>& held) {
  const std::vector<Body> bodies = bodies_of(mesh);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].pieces.size() > kMostPieces)
      throw Error(ErrorKind::input, Stage::fea, "fea.loose_pieces",
                  "The part falls into " + std::to_string(bodies[b].pieces.size()) +
                      " pieces that touch each other in edges and corners only.",
                  "Close the gaps between them in your CAD program.");
    std::vector<std::string> texts = BodyMotion(mesh, bodies[b]).free_motions(held);
    if (texts.empty()) continue;
    if (bodies.size() > 1)
      texts.front().append(" (body " + std::to_string(b + 1) + " of " +
                           std::to_string(bodies.size()) + ")");
    return texts;
  }
  return {};
}

}  // namespace s3
