// Direct factorisations behind SpdSolver: Eigen's own, and SuiteSparse's supernodal Cholesky in
// builds with S3_WITH_CHOLMOD.
#include <Eigen/SparseCholesky>
#ifdef S3_WITH_CHOLMOD
#include <Eigen/CholmodSupport>
#endif

#include "math/solver_kinds.h"

namespace s3 {
namespace {

using ColumnMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;

/// Says by has_positive_pivots() whether the matrix was positive definite.
struct Ldlt : Eigen::SimplicialLDLT<ColumnMatrix> {
  bool has_positive_pivots() const { return rows() == 0 || vectorD().minCoeff() > 0; }
};

#ifdef S3_WITH_CHOLMOD
struct Cholmod : Eigen::CholmodSupernodalLLT<ColumnMatrix> {
  Cholmod() { cholmod().print = 0; }
  bool has_positive_pivots() const { return true; }  // or it would not have succeeded
};
#endif

template <class Factorization>
class DirectSolver final : public SpdSolver {
 public:
  void factor(const SparseMatrix& A, Context& ctx) override {
    check_spd(A);
    ctx.checkpoint();
    matrix_ = A;
    factorization_.compute(ColumnMatrix(A));
    if (factorization_.info() != Eigen::Success || !factorization_.has_positive_pivots())
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
  Factorization factorization_;
};

}  // namespace

std::unique_ptr<SpdSolver> make_ldlt_solver() {
  return std::make_unique<DirectSolver<Ldlt>>();
}

#ifdef S3_WITH_CHOLMOD
std::unique_ptr<SpdSolver> make_cholmod_solver() {
  return std::make_unique<DirectSolver<Cholmod>>();
}
#endif

}  // namespace s3
