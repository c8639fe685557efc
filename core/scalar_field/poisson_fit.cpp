#include "scalar_field/poisson_fit.h"

#include "math/sparse_solver.h"

namespace s3 {

Values fit_field(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                 const Directions& direction, double tolerance, Context& ctx) {
  if (anchors.free_count == 0) return anchors.planar;
  // Solved for the difference to planar layers, which is 0 on the anchors.
  Values weight(rest.tet_count());
  Points misfit(rest.tet_count(), 3);
  for (Index t = 0; t < rest.tet_count(); ++t) {
    weight(t) = operators.volume(t);
    misfit.row(t) = weight(t) * (direction.row(t) - build_direction().transpose());
  }
  Values force;
  operators.adjoint(misfit, force, ctx);
  Block right(anchors.free_count, 1), change = Block::Zero(anchors.free_count, 1);
  anchors.gather_free(force, right);

  const auto solver = make_solver({.tolerance = tolerance});
  solver->factor(operators.energy(weight, {}, anchors.free_index, ctx), ctx);
  solver->solve(right, change, ctx);
  Values value = anchors.planar;
  anchors.add_free(change, value);
  return value;
}

}  // namespace s3
