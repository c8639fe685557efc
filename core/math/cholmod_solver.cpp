// SuiteSparse's supernodal Cholesky factorisation behind SpdSolver; part of builds with
// S3_WITH_CHOLMOD only.
#ifdef S3_WITH_CHOLMOD
#include <Eigen/CholmodSupport>

#include "math/solver_kinds.h"

namespace s3 {
namespace {

class CholmodSolver final : public SpdSolver {
 public:
  CholmodSolver() { factorization_.cholmod().print = 0; }

  void factor(const SparseMatrix& A, Context& ctx) override {
    check_spd(A);
    ctx.checkpoint();
    matrix_ = A;
    factorization_.compute(Eigen::SparseMatrix<double, Eigen::ColMajor, Index>(A));
    if (factorization_.info() != Eigen::Success)
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
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double, Eigen::ColMajor, Index>> factorization_;
};

}  // namespace

std::unique_ptr<SpdSolver> make_cholmod_solver() {
  return std::make_unique<CholmodSolver>();
}

}  // namespace s3
#endif
