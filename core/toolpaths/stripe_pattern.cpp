#include "toolpaths/stripe_pattern.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/units.h"
#include "toolpaths/connection_laplacian.h"
#include "toolpaths/direction_field.h"

namespace s3 {
namespace {

/// The rise along every edge that lines and spacing ask for, as its first end counts, and where the
/// second counts the other way.
Connection wanted_rise(const StripeMesh& mesh, const Directions& line, double spacing) {
  Connection wanted;
  const auto n = mesh.edges.ends.size();
  wanted.angle.resize(static_cast<Eigen::Index>(n));
  wanted.mirror.resize(n);
  for (std::size_t e = 0; e < n; ++e) {
    const auto [a, b] = mesh.edges.ends[e];
    const Vec3 na = mesh.normal.row(a), nb = mesh.normal.row(b);
    const Vec3 la = line.row(a), lb = line.row(b);
    const bool mirror = carry_tangent(la, na, nb).dot(lb) < 0;
    const Vec3 edge = mesh.vertices.row(b) - mesh.vertices.row(a);
    const Vec3 across = na.cross(la) + (mirror ? -1 : 1) * nb.cross(lb);
    wanted.mirror[e] = mirror ? 1 : 0;
    wanted.angle(static_cast<Eigen::Index>(e)) = kPi * edge.dot(across) / spacing;
  }
  return wanted;
}

double wrap(double angle) {
  return angle - 2 * kPi * std::round(angle / (2 * kPi));
}

/// Phases carried along a tree: right wherever lines neither converge nor diverge.
Block carried_phases(const StripeMesh& mesh, const Connection& wanted,
                     const StripeAnchors& anchors) {
  const auto n = static_cast<Index>(mesh.vertices.rows());
  struct Link {
    Index to, edge;
  };
  std::vector<Index> begin(static_cast<std::size_t>(n) + 1, 0);
  for (const auto& ends : mesh.edges.ends)
    for (const Index v : ends) ++begin[static_cast<std::size_t>(v) + 1];
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<Link> links(mesh.edges.ends.size() * 2);
  std::vector<Index> fill(begin.begin(), begin.end() - 1);
  for (std::size_t e = 0; e < mesh.edges.ends.size(); ++e)
    for (const int k : {0, 1}) {
      const auto& ends = mesh.edges.ends[e];
      const auto from = static_cast<std::size_t>(ends[static_cast<std::size_t>(k)]);
      links[static_cast<std::size_t>(fill[from]++)] = {ends[static_cast<std::size_t>(1 - k)],
                                                       static_cast<Index>(e)};
    }
  Values phase = Values::Zero(n);
  std::vector<char> known(static_cast<std::size_t>(n), 0);
  std::vector<Index> queue;
  const auto start_at = [&](Index v) {
    known[static_cast<std::size_t>(v)] = 1;
    queue.push_back(v);
  };
  std::size_t next = 0;
  const auto spread = [&] {
    for (; next < queue.size(); ++next) {
      const Index v = queue[next];
      for (Index i = begin[static_cast<std::size_t>(v)]; i < begin[static_cast<std::size_t>(v) + 1];
           ++i) {
        const Link link = links[static_cast<std::size_t>(i)];
        if (known[static_cast<std::size_t>(link.to)]) continue;
        const double rise = wanted.angle(link.edge);
        const bool mirror = wanted.mirror[static_cast<std::size_t>(link.edge)];
        const bool forward = mesh.edges.ends[static_cast<std::size_t>(link.edge)][0] == v;
        if (forward)
          phase(link.to) = mirror ? -(phase(v) + rise) : phase(v) + rise;
        else
          phase(link.to) = (mirror ? -phase(v) : phase(v)) - rise;
        start_at(link.to);
      }
    }
  };
  for (Index v = 0; v < n; ++v)
    if (anchors.weight(v) > 0) {
      phase(v) = anchors.phase(v);
      start_at(v);
    }
  spread();
  for (Index v = 0; v < n; ++v)
    if (!known[static_cast<std::size_t>(v)]) {
      start_at(v);
      spread();
    }
  Block x(2 * n, 1);
  for (Index v = 0; v < n; ++v) {
    x(2 * v, 0) = std::cos(phase(v));
    x(2 * v + 1, 0) = std::sin(phase(v));
  }
  return x;
}

/// Steps of diffusion over √(1/density) towards the wanted rises, each followed by normalisation.
void diffuse(const StripeMesh& mesh, const SparseMatrix& laplacian, const StripeAnchors& anchors,
             double density, int steps, Block& x, const Context& ctx) {
  constexpr double kTolerance = 1e-2;
  const Values mass = density * mesh.vertex_area;
  const Values pull = density * anchors.weight.cwiseProduct(mesh.vertex_area);
  SparseMatrix matrix = laplacian;
  add_to_diagonal(matrix, mass + pull);
  Context own;  // layers run beside each other already
  const auto solver =
      make_solver({.kind = SolverKind::jacobi, .tolerance = kTolerance, .max_iterations = 1000});
  solver->factor(matrix, own);
  Block b(x.rows(), 1);
  for (int step = 0; step < steps; ++step) {
    ctx.checkpoint();
    for (Eigen::Index v = 0; v < mass.size(); ++v) {
      b(2 * v, 0) = mass(v) * x(2 * v, 0) + pull(v) * std::cos(anchors.phase(v));
      b(2 * v + 1, 0) = mass(v) * x(2 * v + 1, 0) + pull(v) * std::sin(anchors.phase(v));
    }
    solver->solve(b, x, own);
    for (Eigen::Index v = 0; v < mass.size(); ++v) {
      const double length = std::hypot(x(2 * v, 0), x(2 * v + 1, 0));
      if (length > 0) x.middleRows(2 * v, 2) /= length;
    }
  }
}

}  // namespace

StripePattern stripe_pattern(const StripeMesh& mesh, const Directions& line,
                             const StripeAnchors& anchors, double spacing, const Context& ctx) {
  const Connection wanted = wanted_rise(mesh, line, spacing);
  const SparseMatrix laplacian = connection_laplacian(mesh.edges.ends, mesh.edge_weight, wanted,
                                                      Values::Zero(mesh.vertices.rows()));
  Block x = carried_phases(mesh, wanted, anchors);
  // Diffusion lengths in spacings, and steps. More of them change next to nothing.
  for (const auto& [reach, steps] : {std::pair(4.0, 2), std::pair(2.0, 3)})
    diffuse(mesh, laplacian, anchors, 1 / (reach * reach * spacing * spacing), steps, x, ctx);
  // A level that meets a vertex exactly would be counted differently from two sides.
  constexpr double kClear = 1e-6;
  StripePattern pattern;
  pattern.mirror = wanted.mirror;
  pattern.phase.resize(mesh.vertices.rows());
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    pattern.phase(v) =
        std::clamp(std::atan2(x(2 * v + 1, 0), x(2 * v, 0)), -kPi + kClear, kPi - kClear);
  pattern.rise.resize(wanted.angle.size());
  for (std::size_t e = 0; e < mesh.edges.ends.size(); ++e) {
    const auto [a, b] = mesh.edges.ends[e];
    const auto row = static_cast<Eigen::Index>(e);
    const double at_b = wanted.mirror[e] ? -pattern.phase(b) : pattern.phase(b);
    pattern.rise(row) = wanted.angle(row) + wrap(at_b - pattern.phase(a) - wanted.angle(row));
  }
  return pattern;
}

}  // namespace s3
