#include "toolpaths/direction_field.h"

#include <cmath>

#include "toolpaths/connection_laplacian.h"

namespace s3 {
namespace {

// Of w: smoothing where the confidence is 1. With 2, lines converge and end more often: a percent
// of the area more whose spacing is not even.
constexpr double kReach = 3.0;
constexpr double kLeastConfidence = 1e-3;  // keeps the system definite where there is no stress
constexpr double kTolerance = 1e-2;

/// A frame of the tangent plane at each vertex.
struct Frames {
  Directions x, y;
};

Frames make_frames(const Directions& normal) {
  Frames frames{normal, normal};
  for (Eigen::Index v = 0; v < normal.rows(); ++v) {
    const Vec3 n = normal.row(v), x = n.unitOrthogonal();
    frames.x.row(v) = x;
    frames.y.row(v) = n.cross(x);
  }
  return frames;
}

double angle_in_frame(const Frames& frames, Eigen::Index v, const Vec3& tangent) {
  return std::atan2(tangent.dot(Vec3(frames.y.row(v))), tangent.dot(Vec3(frames.x.row(v))));
}

/// Twice the angle by which the frames of an edge's ends differ.
Connection line_connection(const StripeMesh& mesh, const Frames& frames) {
  Connection connection;
  const auto n = mesh.edges.ends.size();
  connection.angle.resize(static_cast<Eigen::Index>(n));
  connection.mirror.assign(n, 0);
  for (std::size_t e = 0; e < n; ++e) {
    const auto [a, b] = mesh.edges.ends[e];
    const Vec3 carried = carry_tangent(frames.x.row(a), mesh.normal.row(a), mesh.normal.row(b));
    connection.angle(static_cast<Eigen::Index>(e)) = 2 * angle_in_frame(frames, b, carried);
  }
  return connection;
}

}  // namespace

Vec3 carry_tangent(const Vec3& tangent, const Vec3& from_normal, const Vec3& to_normal) {
  const Vec3 axis = from_normal.cross(to_normal);
  const double c = std::max(from_normal.dot(to_normal), -0.999);
  return c * tangent + axis.cross(tangent) + axis * (axis.dot(tangent) / (1 + c));
}

Directions direction_field(const StripeMesh& mesh, const LayerStress& stress,
                           const LineGuides& guides, const Directions& start, double width,
                           const Context& ctx) {
  const Eigen::Index n = mesh.vertices.rows();
  const Frames frames = make_frames(mesh.normal);
  Values trust = Values::Zero(n);
  Block wanted = Block::Zero(2 * n, 1);
  const auto ask = [&](Index v, const Vec3& direction, double weight) {
    const double angle = 2 * angle_in_frame(frames, v, direction);
    trust(v) += weight;
    wanted(2 * v, 0) += weight * std::cos(angle);
    wanted(2 * v + 1, 0) += weight * std::sin(angle);
  };
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    const Index from = mesh.origin[static_cast<std::size_t>(f)];
    const Vec3 direction = stress.direction.row(from);
    for (int k = 0; k < 3; ++k) {
      const Index v = mesh.triangles(f, k);
      ask(v, direction, mesh.vertex_area(v) / 6 * stress.confidence(from));
    }
  }
  for (Index v = 0; v < n; ++v)
    if (guides.trust(v) > 0) ask(v, guides.direction.row(v), guides.trust(v) * mesh.vertex_area(v));
  const SparseMatrix matrix = connection_laplacian(
      mesh.edges.ends, kReach * kReach * width * width * mesh.edge_weight,
      line_connection(mesh, frames), trust + kLeastConfidence * mesh.vertex_area);
  Context own;  // layers run beside each other already
  const auto solver =
      make_solver({.kind = SolverKind::jacobi, .tolerance = kTolerance, .max_iterations = 2000});
  solver->factor(matrix, own);
  Block line = wanted;
  for (Eigen::Index v = 0; v < n; ++v) {
    if (start.rows() == 0) {
      line.middleRows(2 * v, 2) /= std::max(trust(v), kLeastConfidence * mesh.vertex_area(v));
    } else {
      const double angle = 2 * angle_in_frame(frames, v, start.row(v));
      line.middleRows(2 * v, 2) << std::cos(angle), std::sin(angle);
    }
  }
  ctx.checkpoint();
  solver->solve(wanted, line, own);
  Directions field(n, 3);
  for (Eigen::Index v = 0; v < n; ++v) {
    const double angle = 0.5 * std::atan2(line(2 * v + 1, 0), line(2 * v, 0));
    field.row(v) = std::cos(angle) * frames.x.row(v) + std::sin(angle) * frames.y.row(v);
  }
  return field;
}

}  // namespace s3
