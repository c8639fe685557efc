// One door to symmetric positive definite linear systems, with several right-hand sides and warm
// starts.
#pragma once
#include <memory>
#include <string>

#include <Eigen/SparseCore>

#include "base/context.h"
#include "base/types.h"

namespace s3 {

/// Row-major: rows are what threads share out. Symmetric matrices store both triangles.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, Index>;
/// #rows×#right-hand sides, row-major so that all right-hand sides of a row share a cache line.
using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

enum class SolverKind {
  multigrid,  // conjugate gradients with a smoothed-aggregation multigrid preconditioner (default)
  jacobi,     // conjugate gradients with a diagonal preconditioner
  ldlt,       // Eigen's direct solver: small systems, oracle
  cholmod     // SuiteSparse's direct solver: native builds only, oracle
};

struct SolverOptions {
  SolverKind kind = SolverKind::multigrid;
  double tolerance =
      1e-6;  // ‖b − A x‖ ≤ tolerance·‖b‖ for every right-hand side (direct kinds ignore it)
  int max_iterations = 500;
  /// Near-nullspace of A for multigrid, #rows×k; empty means one constant vector. Rows of one block
  /// of `block_size` consecutive unknowns are aggregated together (3 for elasticity, 1 for scalar
  /// problems).
  Block near_nullspace = {};
  int block_size = 1;
};

struct SolveReport {
  int iterations = 0;
  double relative_residual = 0;  // the worst of the right-hand sides
  bool converged = true;
};

class SpdSolver {
 public:
  virtual ~SpdSolver() = default;

  /// Analyses and prepares A (n×n, symmetric, positive diagonal, finite: checked). A is copied as
  /// needed.
  /// @throws Error "solver.not_spd" where the checks fail
  virtual void factor(const SparseMatrix& A, Context& ctx) = 0;

  /// Solves A X = B for all columns. X (n×k) is the warm start on entry and the solution on exit.
  virtual SolveReport solve(const Block& B, Block& X, Context& ctx) const = 0;

  /// The tolerance of later solves; a loose one is enough inside alternating schemes.
  virtual void set_tolerance(double tolerance) = 0;
};

/// @throws Error "solver.unavailable" for kinds this build does not have
std::unique_ptr<SpdSolver> make_solver(const SolverOptions& options = {});

}  // namespace s3
