#include <cmath>
#include <functional>

#include <doctest/doctest.h>

#include "grid_mesh.h"
#include "math/multigrid.h"
#include "test_systems.h"

using namespace s3;
using namespace s3::test;

namespace {

/// Vertices shaken by up to a fifth of a cell: no two tets alike, as in a real mesh.
TetMesh shaken_grid(int cells) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  return make_grid(cells, cells, cells, Vec3::Constant(cells), [&](const Vec3& p) {
    return Vec3(p + Vec3(shift(random), shift(random), shift(random)));
  });
}

struct System {
  std::string name;
  SparseMatrix matrix;
  int columns = 1;
  Block near_nullspace = {};
  int block_size = 1;

  std::unique_ptr<SpdSolver> solver(SolverKind kind, double tolerance) const {
    return make_solver({.kind = kind,
                        .tolerance = tolerance,
                        .near_nullspace = near_nullspace,
                        .block_size = block_size});
  }
};

std::vector<System> systems(int cells) {
  const TetMesh mesh = shaken_grid(cells);
  return {{"grid", grid_laplacian(2 * cells), 2},
          {"blend", blend_system(mesh, 1.0, 0.5 * cells), 4},
          {"blend, uneven weights", blend_system(mesh, 1.0, 0.5 * cells, 50), 4},
          {"refinement", refinement_system(mesh, 0.01, 0.3, 0.3), 1, linear_functions(mesh)},
          {"refinement, constants", refinement_system(mesh, 0.01, 0.3, 0.3), 1},
          {"elasticity", elasticity_system(mesh, 0.3), 1, rigid_body_modes(mesh), 3}};
}

int iterations(const System& system, const Block& B) {
  Context ctx;
  const auto solver = system.solver(SolverKind::multigrid, 1e-6);
  solver->factor(system.matrix, ctx);
  Block X = Block::Zero(B.rows(), B.cols());
  const SolveReport report = solver->solve(B, X, ctx);
  CHECK(report.converged);
  return report.iterations;
}

}  // namespace

TEST_CASE("multigrid agrees with direct solvers on the pipeline's systems") {
  for (const System& system : systems(8)) {
    CAPTURE(system.name);
    const Block exact = random_block(system.matrix.rows(), system.columns);
    const Block B = system.matrix * exact;
    Block X = Block::Zero(B.rows(), B.cols()), direct = X;
    Context ctx;
    const auto multigrid = system.solver(SolverKind::multigrid, 1e-11);
    multigrid->factor(system.matrix, ctx);
    CHECK(multigrid->solve(B, X, ctx).converged);
    CHECK((X - exact).norm() < 1e-7 * exact.norm());
    std::vector<SolverKind> direct_kinds = {SolverKind::ldlt};
#ifdef S3_WITH_CHOLMOD
    direct_kinds.push_back(SolverKind::cholmod);
#endif
    for (const SolverKind kind : direct_kinds) {
      const auto solver = system.solver(kind, 0);
      solver->factor(system.matrix, ctx);
      solver->solve(B, direct, ctx);
      CHECK((X - direct).norm() < 1e-7 * direct.norm());
    }
  }
}

TEST_CASE("the number of iterations hardly grows with the size") {
  const std::vector<System> small = systems(6), large = systems(18);
  for (std::size_t s = 0; s < small.size(); ++s) {
    CAPTURE(small[s].name);
    const auto load = [](const System& system) {
      return random_block(system.matrix.rows(), system.columns);
    };
    const int few = iterations(small[s], load(small[s]));
    const int many = iterations(large[s], load(large[s]));
    CAPTURE(few);
    CHECK(many <=
          few + few / 2 +
              4);  // for 27 times the unknowns; the diagonal preconditioner needs 3 times as many
    CHECK(many <= 40);
  }
}

TEST_CASE("a warm start near the solution saves iterations") {
  const System system = systems(12)[1];
  const Block exact = random_block(system.matrix.rows(), 4);
  const Block B = system.matrix * exact;
  Context ctx;
  const auto solver = system.solver(SolverKind::multigrid, 1e-6);
  solver->factor(system.matrix, ctx);
  Block cold = Block::Zero(B.rows(), 4), warm = exact + 1e-4 * random_block(B.rows(), 4);
  CHECK(solver->solve(B, warm, ctx).iterations + 2 < solver->solve(B, cold, ctx).iterations);
  solver->set_tolerance(1e-2);
  Block loose = Block::Zero(B.rows(), 4);
  CHECK(solver->solve(B, loose, ctx).iterations <= 5);
}

TEST_CASE("parts that do not touch, and parts that nothing holds, are solved together") {
  // Two boxes, of which only the first is held, and single unknowns: the system is singular on the
  // second box, and the right-hand side balances there.
  const TetMesh mesh = shaken_grid(8);
  const SparseMatrix held = blend_system(mesh, 1.0, 4), loose = blend_system(mesh, 1.0, -1);
  const Index n = mesh.tet_count(), alone = 40;
  Entries entries;
  for (Index i = 0; i < n; ++i) {
    for (SparseMatrix::InnerIterator it(held, i); it; ++it)
      entries.emplace_back(i, it.col(), it.value());
    for (SparseMatrix::InnerIterator it(loose, i); it; ++it)
      entries.emplace_back(n + i, n + it.col(), it.value());
  }
  for (Index i = 0; i < alone; ++i) entries.emplace_back(2 * n + i, 2 * n + i, 1e-3 * (i + 1));
  const SparseMatrix A = assemble(2 * n + alone, entries);
  const Block exact = random_block(A.rows(), 2);
  const Block B = A * exact;
  Context ctx;
  const auto solver = make_solver({.tolerance = 1e-8});
  solver->factor(A, ctx);
  Block X = Block::Zero(A.rows(), 2);
  const SolveReport report = solver->solve(B, X, ctx);
  CHECK(report.converged);
  CHECK(report.iterations < 40);
  CHECK((B - A * X).norm() < 2e-8 * B.norm());
  CHECK((X - exact).topRows(n).norm() < 1e-4 * exact.topRows(n).norm());
}

TEST_CASE("a diagonal matrix of any size takes one cycle's worth of work") {
  SparseMatrix A(2000, 2000);
  for (Index i = 0; i < 2000; ++i) A.insert(i, i) = 1 + i;
  const Block B = random_block(2000, 1);
  Context ctx;
  const auto solver = make_solver({});
  solver->factor(A, ctx);
  Block X = Block::Zero(2000, 1);
  CHECK(solver->solve(B, X, ctx).converged);
  CHECK((A * X - B).norm() < 1e-6 * B.norm());
}

TEST_CASE("block systems give the same answer for every number of threads") {
  const System system = systems(12).back();
  const Block B = random_block(system.matrix.rows(), 3);
  const auto run = [&](int threads) {
    Context ctx(threads);
    const auto solver = system.solver(SolverKind::multigrid, 1e-6);
    solver->factor(system.matrix, ctx);
    Block X = Block::Zero(B.rows(), 3);
    solver->solve(B, X, ctx);
    return X;
  };
  const Block one = run(1);
  CHECK(one == run(2));
  CHECK(one == run(4));
}

TEST_CASE("the V-cycle is a symmetric positive definite map, and its levels cost little") {
  for (const System& system : systems(10)) {
    CAPTURE(system.name);
    Context ctx;
    Multigrid multigrid;
    multigrid.build(system.matrix, system.near_nullspace, system.block_size, ctx);
    CHECK(multigrid.levels() > 1);
    CHECK(multigrid.operator_complexity() <
          3);  // 2.5 with four vectors on one unknown, 1.2 to 2 else
    const Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor> R =
        random_block(system.matrix.rows(), 2).cast<float>();
    Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor> Z(R.rows(), 2);
    multigrid.apply(R.data(), Z.data(), 2, ctx.pool);
    const Eigen::Matrix2d G = R.cast<double>().transpose() * Z.cast<double>();
    CHECK(G(0, 0) > 0);
    CHECK(G.determinant() > 0);
    CHECK(std::abs(G(0, 1) - G(1, 0)) < 1e-4 * std::sqrt(G(0, 0) * G(1, 1)));
  }
}

TEST_CASE("sizes that do not fit are refused") {
  const SparseMatrix A = grid_laplacian(5);
  Context ctx;
  CHECK_THROWS_AS(make_solver({.block_size = 3})->factor(A, ctx), Error);
  CHECK_THROWS_AS(make_solver({.near_nullspace = Block::Ones(7, 1)})->factor(A, ctx), Error);
  CHECK_THROWS_AS(make_solver({.near_nullspace = Block::Ones(125, 40)})->factor(A, ctx), Error);
}
