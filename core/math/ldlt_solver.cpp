// Eigen's direct solver behind SpdSolver.
#include <Eigen/SparseCholesky>

#include "math/solver_kinds.h"

namespace s3 {
namespace {

class LdltSolver final : public SpdSolver {
 public:
  void factor(const SparseMatrix& A, Context& ctx) override {
    check_spd(A);
    ctx.checkpoint();
    matrix_ = A;
    factorization_.compute(Eigen::SparseMatrix<double, Eigen::ColMajor, Index>(A));
    if (factorization_.info() != Eigen::Success ||
        (A.rows() > 0 && !(factorization_.vectorD().minCoeff() > 0)))
      throw Error(ErrorKind::slicing, Stage::deformation, "solver.not_spd",
                  "The linear system is not positive definite: its factorisation failed.",
                  "Check the mesh for degenerate tets.");
  }

  SolveReport solve(const Block& B, Block& X, Context& ctx) const override {
    check_sizes(matrix_.rows(), B, X);
    ctx.checkpoint();
    SolveReport report;
    if (B.size() == 0) return report;
    X = factorization_.solve(Eigen::MatrixXd(B));
    report.relative_residual = worst_residual(matrix_, B, X);
    return report;
  }

  void set_tolerance(double) override {}

 private:
  SparseMatrix matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double, Eigen::ColMajor, Index>> factorization_;
};

}  // namespace

std::unique_ptr<SpdSolver> make_ldlt_solver() {
  return std::make_unique<LdltSolver>();
}

}  // namespace s3
