// Crane, Weischedel & Wardetzky, "The Heat Method for Distance Computation", CACM 60(11), 2017, on
// tets instead of triangles.
#include "scalar_field/heat_distance.h"

#include <cmath>

#include "math/sparse_solver.h"
#include "scalar_field/poisson_fit.h"

namespace s3 {

namespace {

// Heat falls to e^(-distance / √time). Below kLeastHeat the direction in which it falls would be
// that of the solver's error.
constexpr double kLeastHeat = 1e-6;
constexpr double kHeatTolerance = 1e-11;
constexpr double kFitTolerance = 1e-6;
// √time as a share of the part's size: e^-12 across it is above kLeastHeat, and longer paths get
// more time.
constexpr double kShortest = 1.0 / 12;
constexpr double kLonger = 1.6;
constexpr int kMostTries = 10;  // 1.6^10: paths of 100 times the part's size

/// Temperature of every vertex after `time`, mm²: (id − time Δ) u = 0, u = 1 on the anchors, no
/// flow through the surface elsewhere.
Values spread_heat(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                   double time, Context& ctx) {
  const Index vertices = rest.vertex_count();
  Values stiffness(rest.tet_count()), mass = Values::Zero(vertices), heat(vertices);
  for (Index t = 0; t < rest.tet_count(); ++t) {
    stiffness(t) = time * operators.volume(t);
    for (int i = 0; i < 4; ++i) mass(rest.tets(t, i)) += 0.25 * operators.volume(t);
  }
  for (Index v = 0; v < vertices; ++v) heat(v) = anchors.free_index[v] < 0 ? 1 : 0;
  SparseMatrix A = operators.energy(stiffness, {}, anchors.free_index, ctx);
  for (Index v = 0; v < vertices; ++v)
    if (const Index row = anchors.free_index[v]; row >= 0) A.coeffRef(row, row) += mass(v);

  Points flow;
  operators.gradients(heat, flow, ctx);
  for (Index t = 0; t < rest.tet_count(); ++t) flow.row(t) *= -stiffness(t);
  Values source;
  operators.adjoint(flow, source, ctx);
  Block right(anchors.free_count, 1), found = Block::Zero(anchors.free_count, 1);
  anchors.gather_free(source, right);
  const auto solver = make_solver({.tolerance = kHeatTolerance});
  solver->factor(A, ctx);
  solver->solve(right, found, ctx);
  anchors.add_free(found, heat);
  return heat;
}

bool reaches_all(const FieldOperators& operators, const Values& heat) {
  for (Index v = 0; v < heat.size(); ++v)
    if (operators.in_use(v) && heat(v) < kLeastHeat) return false;
  return true;
}

Directions unit_rows(Points vectors) {
  for (Eigen::Index t = 0; t < vectors.rows(); ++t) {
    const double length = vectors.row(t).norm();
    vectors.row(t) = length > 0 ? Vec3(vectors.row(t) / length) : build_direction();
  }
  return vectors;
}

}  // namespace

Values heat_distance(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                     Context& ctx) {
  if (anchors.free_count == 0) return anchors.planar;
  double root_time = kShortest * bounding_box(rest.vertices).diagonal();
  Values heat = spread_heat(rest, operators, anchors, root_time * root_time, ctx);
  for (int i = 0; i < kMostTries && !reaches_all(operators, heat); ++i) {
    root_time *= kLonger;
    heat = spread_heat(rest, operators, anchors, root_time * root_time, ctx);
  }
  Points falling;
  operators.gradients(heat, falling, ctx);
  return fit_field(rest, operators, anchors, unit_rows(-falling), kFitTolerance, ctx);
}

Directions heat_directions(const TetMesh& rest, const FieldOperators& operators,
                           const Anchors& anchors, Context& ctx) {
  Points gradient;
  operators.gradients(heat_distance(rest, operators, anchors, ctx), gradient, ctx);
  return unit_rows(std::move(gradient));
}

}  // namespace s3
