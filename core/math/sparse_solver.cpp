#include "math/sparse_solver.h"

#include <cmath>

#include "math/solver_kinds.h"

namespace s3 {
namespace {

// Assembly in another order may differ in the last digits; more than this is another matrix.
constexpr double kSymmetryTolerance = 1e-9;

[[noreturn]] void not_spd(const std::string& message) {
  throw Error(ErrorKind::slicing, Stage::deformation, "solver.not_spd", message,
              "Check the mesh for degenerate tets.");
}

void check_entries(const SparseMatrix& A) {
  for (Index i = 0; i < A.rows(); ++i) {
    double diagonal = 0;
    for (SparseMatrix::InnerIterator it(A, i); it; ++it) {
      if (!std::isfinite(it.value()))
        not_spd("The linear system has an entry that is not a number, in row " + std::to_string(i) +
                ".");
      if (it.col() == i) diagonal += it.value();
    }
    if (!(diagonal > 0))
      not_spd("The linear system's diagonal is not positive in row " + std::to_string(i) + ".");
  }
}

/// Walks the rows in order and, for every column, the entries of that row in order: the transposed
/// entry of (i, j) is always the next one of row j that has not been met. One pass, no transposed
/// copy.
void check_symmetry(const SparseMatrix& A) {
  std::vector<Index> next(A.outerIndexPtr(), A.outerIndexPtr() + A.rows());
  const auto asymmetric = [](Index i, Index j) {
    not_spd("The linear system is not symmetric at (" + std::to_string(i) + ", " +
            std::to_string(j) + ").");
  };
  for (Index i = 0; i < A.rows(); ++i)
    for (Index k = A.outerIndexPtr()[i]; k < A.outerIndexPtr()[i + 1]; ++k) {
      const Index j = A.innerIndexPtr()[k];
      const Index mirror = next[j]++;
      if (mirror >= A.outerIndexPtr()[j + 1] || A.innerIndexPtr()[mirror] != i) asymmetric(i, j);
      const double a = A.valuePtr()[k], b = A.valuePtr()[mirror];
      if (std::abs(a - b) > kSymmetryTolerance * std::max(std::abs(a), std::abs(b)) &&
          std::abs(a - b) > kSymmetryTolerance * std::sqrt(std::abs(A.coeff(i, i) * A.coeff(j, j))))
        asymmetric(i, j);
    }
}

}  // namespace

void check_spd(const SparseMatrix& A) {
  if (A.rows() != A.cols())
    not_spd("The linear system is not square: " + std::to_string(A.rows()) + "×" +
            std::to_string(A.cols()) + ".");
  if (!A.isCompressed()) {
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    check_spd(compressed);
    return;
  }
  check_entries(A);
  check_symmetry(A);
}

void check_sizes(Eigen::Index rows, const Block& B, const Block& X) {
  if (B.rows() != rows || X.rows() != rows || X.cols() != B.cols())
    throw Error(ErrorKind::slicing, Stage::deformation, "solver.bad_size",
                "A system of " + std::to_string(rows) + " rows got a right-hand side of " +
                    std::to_string(B.rows()) + "×" + std::to_string(B.cols()) + " and a start of " +
                    std::to_string(X.rows()) + "×" + std::to_string(X.cols()) + ".");
}

double worst_residual(const SparseMatrix& A, const Block& B, const Block& X) {
  const Block residual = B - A * X;
  double worst = 0;
  for (Eigen::Index c = 0; c < B.cols(); ++c)
    if (const double b = B.col(c).norm(); b > 0)
      worst = std::max(worst, residual.col(c).norm() / b);
  return worst;
}

std::unique_ptr<SpdSolver> make_solver(const SolverOptions& options) {
  switch (options.kind) {
    case SolverKind::multigrid:
    case SolverKind::jacobi:
      return make_conjugate_gradient_solver(options);
    case SolverKind::ldlt:
      return make_ldlt_solver();
    case SolverKind::cholmod:
#ifdef S3_WITH_CHOLMOD
      return make_cholmod_solver();
#else
      break;
#endif
  }
  throw Error(ErrorKind::input, Stage::deformation, "solver.unavailable",
              "This build does not have the solver CHOLMOD.",
              "Configure with S3_WITH_CHOLMOD=ON, or use multigrid.");
}

}  // namespace s3
