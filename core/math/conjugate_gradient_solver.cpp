// The iterative kinds of SpdSolver: conjugate gradients with one preconditioner or another.
#include <vector>

#include "math/conjugate_gradient.h"
#include "math/multigrid.h"
#include "math/solver_kinds.h"

namespace s3 {
namespace {

class Jacobi final : public Preconditioner {
 public:
  explicit Jacobi(const SparseMatrix& A) : inverse_(static_cast<std::size_t>(A.rows())) {
    const Eigen::VectorXd diagonal = A.diagonal();
    const double scale = diagonal.size() > 0 ? diagonal.maxCoeff() : 1;
    for (std::size_t i = 0; i < inverse_.size(); ++i)
      inverse_[i] = static_cast<float>(scale / diagonal[static_cast<Eigen::Index>(i)]);
  }

  void apply(const float* r, float* z, int columns, ThreadPool& pool) const override {
    const auto n = static_cast<std::size_t>(columns);
    parallel_for(pool, inverse_.size(), 8192, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t c = 0; c < n; ++c) z[i * n + c] = inverse_[i] * r[i * n + c];
    });
  }

 private:
  std::vector<float> inverse_;
};

class ConjugateGradientSolver final : public SpdSolver {
 public:
  explicit ConjugateGradientSolver(SolverOptions options) : options_(std::move(options)) {}

  void factor(const SparseMatrix& A, Context& ctx) override {
    check_spd(A);
    ctx.checkpoint();
    matrix_ = A;
    matrix_.makeCompressed();
    if (options_.kind == SolverKind::jacobi) {
      preconditioner_ = std::make_unique<Jacobi>(matrix_);
      return;
    }
    auto multigrid = std::make_unique<Multigrid>();
    multigrid->build(matrix_, options_.near_nullspace, options_.block_size, ctx);
    preconditioner_ = std::move(multigrid);
  }

  SolveReport solve(const Block& B, Block& X, Context& ctx) const override {
    check_sizes(matrix_.rows(), B, X);
    if (B.size() == 0) return {};
    return conjugate_gradient(matrix_, *preconditioner_, B, X, options_.tolerance,
                              options_.max_iterations, ctx);
  }

  void set_tolerance(double tolerance) override { options_.tolerance = tolerance; }

 private:
  SolverOptions options_;
  SparseMatrix matrix_;
  std::unique_ptr<Preconditioner> preconditioner_;
};

}  // namespace

std::unique_ptr<SpdSolver> make_conjugate_gradient_solver(const SolverOptions& options) {
  return std::make_unique<ConjugateGradientSolver>(options);
}

}  // namespace s3
