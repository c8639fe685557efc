#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include "grid_mesh.h"
#include "math/sparse_solver.h"
#include "test_systems.h"

using namespace s3;
using namespace s3::test;

namespace {

double worst_residual(const SparseMatrix& A, const Block& B, const Block& X) {
  const Block R = B - A * X;
  double worst = 0;
  for (Eigen::Index c = 0; c < B.cols(); ++c)
    worst = std::max(worst, R.col(c).norm() / B.col(c).norm());
  return worst;
}

std::string error_code(const SparseMatrix& A, SolverKind kind) {
  Context ctx;
  try {
    make_solver({.kind = kind})->factor(A, ctx);
  } catch (const Error& error) {
    return error.code;
  }
  return "";
}

constexpr SolverKind kAllKinds[] = {SolverKind::multigrid, SolverKind::jacobi, SolverKind::ldlt};

}  // namespace

TEST_CASE("every solver kind reaches its tolerance in every column, for any number of columns") {
  const SparseMatrix A = grid_laplacian(12);
  for (const SolverKind kind : kAllKinds)
    for (const int columns : {1, 2, 3, 4, 5, 9}) {
      Context ctx;
      const auto solver = make_solver({.kind = kind, .tolerance = 1e-8});
      solver->factor(A, ctx);
      Block B = random_block(A.rows(), columns);
      B.col(0) *= 1e-9;  // a column of another size must be as accurate as the rest
      Block X = Block::Zero(A.rows(), columns);
      const SolveReport report = solver->solve(B, X, ctx);
      CHECK(report.converged);
      CHECK(report.relative_residual <= 1e-8);
      CHECK(worst_residual(A, B, X) < 1.01e-8);
    }
}

TEST_CASE("a solver takes a system of one row, and right-hand sides without columns or of zeros") {
  SparseMatrix one(1, 1);
  one.insert(0, 0) = 4;
  const SparseMatrix A = grid_laplacian(3);
  for (const SolverKind kind : kAllKinds) {
    Context ctx;
    const auto solver = make_solver({.kind = kind});
    solver->factor(one, ctx);
    Block X = Block::Zero(1, 1);
    solver->solve(Block::Constant(1, 1, 2.0), X, ctx);
    CHECK(X(0, 0) == doctest::Approx(0.5));

    solver->factor(A, ctx);
    Block none(A.rows(), 0);
    CHECK(solver->solve(Block(A.rows(), 0), none, ctx).converged);
    Block start = Block::Ones(A.rows(), 2);
    Block B = Block::Zero(A.rows(), 2);
    B.col(1).setOnes();
    CHECK(solver->solve(B, start, ctx).converged);
    CHECK(start.col(0).norm() == 0);
    CHECK(start.col(1).norm() > 0);
  }
}

TEST_CASE("the exact solution as start takes no iteration") {
  const SparseMatrix A = grid_laplacian(10);
  const Block exact = random_block(A.rows(), 3);
  const Block B = A * exact;
  for (const SolverKind kind : {SolverKind::multigrid, SolverKind::jacobi}) {
    Context ctx;
    const auto solver = make_solver({.kind = kind});
    solver->factor(A, ctx);
    Block X = exact;
    CHECK(solver->solve(B, X, ctx).iterations == 0);
    CHECK(X == exact);
  }
}

TEST_CASE("the answer does not depend on the number of threads") {
  const SparseMatrix A = grid_laplacian(30);
  const Block B = random_block(A.rows(), 4);
  for (const SolverKind kind : {SolverKind::multigrid, SolverKind::jacobi}) {
    const auto run = [&](int threads) {
      Context ctx(threads);
      const auto solver = make_solver({.kind = kind});
      solver->factor(A, ctx);
      Block X = Block::Zero(A.rows(), 4);
      solver->solve(B, X, ctx);
      return X;
    };
    const Block one = run(1);
    CHECK(one == run(2));
    CHECK(one == run(3));
  }
}

TEST_CASE("matrices that are not symmetric positive definite are refused") {
  const SparseMatrix good = grid_laplacian(4);
  for (const SolverKind kind : kAllKinds) {
    CHECK(error_code(good, kind) == "");
    SparseMatrix A = good;
    A.coeffRef(3, 4) = -0.5;
    CHECK(error_code(A, kind) == "solver.not_spd");
    A = good;
    A.coeffRef(5, 5) = 0;
    CHECK(error_code(A, kind) == "solver.not_spd");
    A.coeffRef(5, 5) = -2;
    CHECK(error_code(A, kind) == "solver.not_spd");
    A.coeffRef(5, 5) = std::numeric_limits<double>::quiet_NaN();
    CHECK(error_code(A, kind) == "solver.not_spd");
    A = good;
    A.coeffRef(0, 20) = 1;  // no counterpart at (20, 0)
    CHECK(error_code(A, kind) == "solver.not_spd");
    CHECK(error_code(SparseMatrix(good.topRows(7)), kind) == "solver.not_spd");
  }
  // Positive diagonal, but indefinite: the direct solver sees it at once, the iterative ones while
  // solving.
  SparseMatrix indefinite(2, 2);
  indefinite.insert(0, 0) = 1;
  indefinite.insert(1, 1) = 1;
  indefinite.insert(0, 1) = 3;
  indefinite.insert(1, 0) = 3;
  CHECK(error_code(indefinite, SolverKind::ldlt) == "solver.not_spd");
}

TEST_CASE("a wrong number of rows is an error and a cancel stops a solve") {
  const SparseMatrix A = grid_laplacian(8);
  for (const SolverKind kind : {SolverKind::multigrid, SolverKind::jacobi, SolverKind::ldlt}) {
    Context ctx;
    const auto solver = make_solver({.kind = kind});
    solver->factor(A, ctx);
    Block X = Block::Zero(A.rows(), 1);
    CHECK_THROWS_AS(solver->solve(Block::Zero(3, 1), X, ctx), Error);
    ctx.cancel_requested = true;
    CHECK_THROWS_AS(solver->solve(random_block(A.rows(), 1), X, ctx), Cancelled);
    CHECK_THROWS_AS(solver->factor(A, ctx), Cancelled);
  }
}

TEST_CASE("an indefinite matrix with a positive diagonal is found out while iterating") {
  SparseMatrix A = grid_laplacian(6);
  for (Index i = 0; i < A.rows(); ++i) A.coeffRef(i, i) = 1;
  for (const SolverKind kind : {SolverKind::multigrid, SolverKind::jacobi}) {
    Context ctx;
    const auto solver = make_solver({.kind = kind});
    Block X = Block::Zero(A.rows(), 1);
    const auto run = [&] {
      solver->factor(A, ctx);
      solver->solve(random_block(A.rows(), 1), X, ctx);
    };
    CHECK_THROWS_WITH_AS(run(), doctest::Contains("not positive definite"), Error);
  }
}

TEST_CASE("slivers of any thinness leave the multigrid preconditioner positive definite") {
  // One layer of vertices is pressed onto the next: tets of height 1, 1e-3, 1e-6.
  for (const double gap : {1.0, 1e-3, 1e-6}) {
    const TetMesh mesh = make_grid(9, 9, 9, Vec3::Constant(9), [&](const Vec3& p) {
      return p.z() > 3.5 && p.z() < 4.5 ? Vec3(p.x(), p.y(), 3 + gap) : p;
    });
    const SparseMatrix A = refinement_system(mesh, 0.01, 0.3, 0.3);
    const Block B = A * random_block(A.rows(), 1);
    for (const bool linear : {false, true}) {
      CAPTURE(gap);
      CAPTURE(linear);
      Context ctx;
      const auto solver = make_solver(
          {.tolerance = 1e-5, .near_nullspace = linear ? linear_functions(mesh) : Block()});
      solver->factor(A, ctx);
      Block X = Block::Zero(A.rows(), 1);
      const SolveReport report = solver->solve(B, X, ctx);
      CHECK(report.converged);
      CHECK(report.iterations < 60);
    }
  }
}
