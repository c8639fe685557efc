// Hestenes & Stiefel's conjugate gradients, each column with its own step lengths. All vector
// operations of an iteration are fused into the passes that need them, because the iteration is
// bound by memory bandwidth.
#include "math/conjugate_gradient.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace s3 {
namespace {

// Fixed chunks (part of the answer's last digits, so not tuned to the machine).
constexpr std::size_t kGrain = 4096;

[[noreturn]] void not_definite(const char* vector, const char* product, double value) {
  std::array<char, 32> number;
  std::snprintf(number.data(), number.size(), "%g", value);
  throw Error(ErrorKind::slicing, Stage::deformation, "solver.not_spd",
              std::string("The linear system is not positive definite: ") + vector + " has " +
                  product + " = " + number.data() + ".",
              "Check the mesh for degenerate tets.");
}

template <int N>
struct Sums {
  std::array<double, N> value = {};
  Sums& operator+=(const Sums& other) {
    for (int c = 0; c < N; ++c) value[c] += other.value[c];
    return *this;
  }
};

/// The columns of one group, interleaved; N is known to the compiler so that the inner loops
/// unroll.
template <int N>
class Group {
 public:
  Group(const SparseMatrix& A, const Preconditioner& preconditioner, const double* b, double* x,
        Context& ctx)
      : A_(A),
        preconditioner_(preconditioner),
        n_(static_cast<std::size_t>(A.rows())),
        b_(b),
        x_(x),
        ctx_(ctx) {}

  SolveReport solve(double tolerance, int max_iterations) {
    r_.resize(n_ * N);
    const Sums<N> b_squared = start();
    std::array<double, N> target;
    for (int c = 0; c < N; ++c) target[c] = tolerance * tolerance * b_squared.value[c];

    SolveReport report;
    update_active(target);
    if (any_active()) iterate(target, max_iterations, report);
    report.converged = !any_active();
    for (int c = 0; c < N; ++c)
      if (b_squared.value[c] > 0)
        report.relative_residual =
            std::max(report.relative_residual, std::sqrt(rr_.value[c] / b_squared.value[c]));
    return report;
  }

 private:
  /// r = b − A x. Columns with b = 0 get x = 0, their exact answer. Returns the squared norms of b.
  Sums<N> start() {
    const Sums<N> b_squared =
        parallel_sum(ctx_.pool, n_, kGrain, Sums<N>{}, [&](std::size_t begin, std::size_t end) {
          Sums<N> sum;
          for (std::size_t i = begin; i < end; ++i)
            for (int c = 0; c < N; ++c) sum.value[c] += b_[i * N + c] * b_[i * N + c];
          return sum;
        });
    for (int c = 0; c < N; ++c)
      if (b_squared.value[c] == 0)
        for (std::size_t i = 0; i < n_; ++i) x_[i * N + c] = 0;
    rr_ = parallel_sum(ctx_.pool, n_, kGrain, Sums<N>{}, [&](std::size_t begin, std::size_t end) {
      Sums<N> sum;
      for (std::size_t i = begin; i < end; ++i) {
        const std::array<double, N> ax = row_times(i, x_);
        for (int c = 0; c < N; ++c) {
          const double r = b_[i * N + c] - ax[c];
          r_[i * N + c] = r;
          sum.value[c] += r * r;
        }
      }
      return sum;
    });
    return b_squared;
  }

  void iterate(const std::array<double, N>& target, int max_iterations, SolveReport& report) {
    p_.assign(n_ * N, 0.0);
    ap_.resize(n_ * N);
    r32_.resize(n_ * N);
    z32_.resize(n_ * N);
    // Single precision sees residuals near one: columns are scaled by their first norm.
    for (int c = 0; c < N; ++c) to_single_[c] = rr_.value[c] > 0 ? 1 / std::sqrt(rr_.value[c]) : 0;
    round_residual();
    Sums<N> rz_before;
    for (int k = 0; k < max_iterations && any_active(); ++k) {
      ctx_.checkpoint();
      preconditioner_.apply(r32_.data(), z32_.data(), N, ctx_.pool);
      const Sums<N> rz = residual_dot_z();
      std::array<double, N> beta;
      for (int c = 0; c < N; ++c)
        beta[c] = rz_before.value[c] > 0 ? rz.value[c] / rz_before.value[c] : 0;
      next_direction(beta);
      const Sums<N> pap = multiply_direction();
      std::array<double, N> alpha;
      for (int c = 0; c < N; ++c) alpha[c] = step_length(c, rz.value[c], pap.value[c]);
      step(alpha);
      rz_before = rz;
      ++report.iterations;
      update_active(target);
    }
  }

  double step_length(int c, double rz, double pap) {
    if (!active_[c]) return 0;
    if (pap < 0 || !std::isfinite(pap)) not_definite("a search direction p", "pᵀAp", pap);
    if (rz < 0 || !std::isfinite(rz)) not_definite("the preconditioned residual z", "rᵀz", rz);
    return pap > 0 ? rz / pap : 0;
  }

  std::array<double, N> row_times(std::size_t i, const double* v) const {
    std::array<double, N> sum = {};
    const Index end = A_.outerIndexPtr()[i + 1];
    for (Index k = A_.outerIndexPtr()[i]; k < end; ++k) {
      const double a = A_.valuePtr()[k];
      const double* row = v + static_cast<std::size_t>(A_.innerIndexPtr()[k]) * N;
      for (int c = 0; c < N; ++c) sum[c] += a * row[c];
    }
    return sum;
  }

  void round_residual() {
    parallel_for(ctx_.pool, n_, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (int c = 0; c < N; ++c)
          r32_[i * N + c] = static_cast<float>(r_[i * N + c] * to_single_[c]);
    });
  }

  /// rᵀz, of the rounded residual: z is its image.
  Sums<N> residual_dot_z() {
    return parallel_sum(ctx_.pool, n_, kGrain, Sums<N>{}, [&](std::size_t begin, std::size_t end) {
      Sums<N> sum;
      for (std::size_t i = begin; i < end; ++i)
        for (int c = 0; c < N; ++c) sum.value[c] += r_[i * N + c] * z32_[i * N + c];
      return sum;
    });
  }

  /// p = z + β p
  void next_direction(const std::array<double, N>& beta) {
    parallel_for(ctx_.pool, n_, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (int c = 0; c < N; ++c) p_[i * N + c] = z32_[i * N + c] + beta[c] * p_[i * N + c];
    });
  }

  /// Ap, and pᵀAp on the way
  Sums<N> multiply_direction() {
    return parallel_sum(ctx_.pool, n_, kGrain, Sums<N>{}, [&](std::size_t begin, std::size_t end) {
      Sums<N> sum;
      for (std::size_t i = begin; i < end; ++i) {
        const std::array<double, N> ap = row_times(i, p_.data());
        for (int c = 0; c < N; ++c) {
          ap_[i * N + c] = ap[c];
          sum.value[c] += p_[i * N + c] * ap[c];
        }
      }
      return sum;
    });
  }

  /// x += α p, r −= α Ap, with ‖r‖² and the rounded residual on the way
  void step(const std::array<double, N>& alpha) {
    rr_ = parallel_sum(ctx_.pool, n_, kGrain, Sums<N>{}, [&](std::size_t begin, std::size_t end) {
      Sums<N> sum;
      for (std::size_t i = begin; i < end; ++i)
        for (int c = 0; c < N; ++c) {
          x_[i * N + c] += alpha[c] * p_[i * N + c];
          const double r = r_[i * N + c] - alpha[c] * ap_[i * N + c];
          r_[i * N + c] = r;
          r32_[i * N + c] = static_cast<float>(r * to_single_[c]);
          sum.value[c] += r * r;
        }
      return sum;
    });
  }

  void update_active(const std::array<double, N>& target) {
    for (int c = 0; c < N; ++c) active_[c] = rr_.value[c] > target[c];
  }

  bool any_active() const {
    for (const bool active : active_)
      if (active) return true;
    return false;
  }

  const SparseMatrix& A_;
  const Preconditioner& preconditioner_;
  std::size_t n_;
  const double* b_;
  double* x_;
  Context& ctx_;
  std::vector<double> r_, p_, ap_;
  std::vector<float> r32_, z32_;
  Sums<N> rr_;
  std::array<double, N> to_single_ = {};
  std::array<bool, N> active_ = {};
};

SolveReport solve_group(const SparseMatrix& A, const Preconditioner& preconditioner, const Block& B,
                        Block& X, double tolerance, int max_iterations, Context& ctx) {
  const auto run = [&]<int N>() {
    return Group<N>(A, preconditioner, B.data(), X.data(), ctx).solve(tolerance, max_iterations);
  };
  switch (B.cols()) {
    case 1:
      return run.template operator()<1>();
    case 2:
      return run.template operator()<2>();
    case 3:
      return run.template operator()<3>();
    default:
      return run.template operator()<4>();
  }
}

}  // namespace

SolveReport conjugate_gradient(const SparseMatrix& A, const Preconditioner& preconditioner,
                               const Block& B, Block& X, double tolerance, int max_iterations,
                               Context& ctx) {
  if (B.cols() == 0 || B.rows() == 0) return {};
  if (B.cols() <= kMaxColumns)
    return solve_group(A, preconditioner, B, X, tolerance, max_iterations, ctx);
  SolveReport worst;
  for (Eigen::Index first = 0; first < B.cols(); first += kMaxColumns) {
    const Eigen::Index count = std::min<Eigen::Index>(kMaxColumns, B.cols() - first);
    const Block b = B.middleCols(first, count);
    Block x = X.middleCols(first, count);
    const SolveReport report = solve_group(A, preconditioner, b, x, tolerance, max_iterations, ctx);
    X.middleCols(first, count) = x;
    worst.iterations = std::max(worst.iterations, report.iterations);
    worst.relative_residual = std::max(worst.relative_residual, report.relative_residual);
    worst.converged = worst.converged && report.converged;
  }
  return worst;
}

}  // namespace s3
