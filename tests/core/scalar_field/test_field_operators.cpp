#include <doctest/doctest.h>

#include <random>

#include "carved_mesh.h"
#include "grid_mesh.h"
#include "scalar_field/field_operators.h"
#include "scalar_field/poisson_fit.h"

using namespace s3;

namespace {

Values random_values(Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Values values(n);
  for (Index i = 0; i < n; ++i) values(i) = uniform(random);
  return values;
}

}  // namespace

TEST_CASE("the gradient of a linear function is its slope in every tet") {
  Context ctx;
  const TetMesh mesh = test::make_grid(3, 2, 4, Vec3(3, 5, 4));
  const FieldOperators operators(mesh, ctx);
  const Vec3 slope(0.3, -1.2, 2);
  Points gradient;
  operators.gradients(mesh.vertices * slope, gradient, ctx);
  CHECK((gradient.rowwise() - slope.transpose()).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("the adjoint is the transpose of the gradient") {
  Context ctx;
  const TetMesh mesh = test::make_grid(3, 2, 4, Vec3(3, 5, 4));
  const FieldOperators operators(mesh, ctx);
  const Values v = random_values(mesh.vertex_count(), 1);
  Points p(mesh.tet_count(), 3), gradient;
  p << random_values(mesh.tet_count(), 2), random_values(mesh.tet_count(), 3),
      random_values(mesh.tet_count(), 4);
  operators.gradients(v, gradient, ctx);
  Values adjoint;
  operators.adjoint(p, adjoint, ctx);
  CHECK(adjoint.dot(v) == doctest::Approx(gradient.cwiseProduct(p).sum()));
}

TEST_CASE("the matrix of an energy gives the energy that is summed tet by tet and face by face") {
  Context ctx;
  const TetMesh mesh = test::make_grid(3, 2, 4, Vec3(3, 5, 4));
  const FieldOperators operators(mesh, ctx);
  const Anchors anchors = find_anchors(mesh, make_objectives(mesh, {}, nullptr));
  const Values tet_weight = random_values(mesh.tet_count(), 5).cwiseAbs();
  const Values pair_weight =
      random_values(static_cast<Index>(mesh.face_pairs.rows()), 6).cwiseAbs();
  Values v = random_values(mesh.vertex_count(), 7);
  for (Index i = 0; i < mesh.vertex_count(); ++i)
    if (anchors.free_index[i] < 0) v(i) = 0;
  double expected = 0;
  for (Index t = 0; t < mesh.tet_count(); ++t)
    expected += tet_weight(t) * operators.gradient(v, t).squaredNorm();
  for (Index p = 0; p < mesh.face_pairs.rows(); ++p)
    expected += pair_weight(p) * (operators.gradient(v, mesh.face_pairs(p, 1)) -
                                  operators.gradient(v, mesh.face_pairs(p, 0)))
                                     .squaredNorm();
  const SparseMatrix K = operators.energy(tet_weight, pair_weight, anchors.free_index, ctx);
  Block free(anchors.free_count, 1);
  anchors.gather_free(v, free);
  const Values x = free.col(0);
  CHECK(x.dot(K * x) == doctest::Approx(expected));
  CHECK(SparseMatrix(SparseMatrix(K.transpose()) - K).norm() < 1e-12 * K.norm());
}

TEST_CASE("a component that does not touch the plate is held by its lowest vertex") {
  // Two blocks, 2 mm of air between them.
  const TetMesh mesh = test::make_carved(2, 2, 6, Vec3(2, 2, 6),
                                         [](const Vec3& p) { return p.z() < 2 || p.z() > 4; });
  const Anchors anchors = find_anchors(mesh, make_objectives(mesh, {}, nullptr));
  int on_plate = 0, in_air = 0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (anchors.free_index[v] >= 0) continue;
    (mesh.vertices(v, 2) == 0 ? on_plate : in_air) += 1;
    CHECK((mesh.vertices(v, 2) == 0 || mesh.vertices(v, 2) == 4));
    CHECK(anchors.planar(v) == mesh.vertices(v, 2));
  }
  CHECK(on_plate == 9);
  CHECK(in_air == 1);
}

TEST_CASE("a field is found again from its own gradients") {
  Context ctx;
  const TetMesh mesh = test::make_table();
  const FieldOperators operators(mesh, ctx);
  const Anchors anchors = find_anchors(mesh, make_objectives(mesh, {}, nullptr));
  Values field(mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = mesh.vertices.row(v);
    field(v) = p.z() * (1 + 0.05 * p.x() - 0.02 * p.y());
  }
  Points gradient;
  operators.gradients(field, gradient, ctx);
  const Values found = fit_field(mesh, operators, anchors, gradient, 1e-10, ctx);
  CHECK((found - field).cwiseAbs().maxCoeff() < 1e-6);
}
