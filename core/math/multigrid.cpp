// Smoothed aggregation after Vaněk, Mandel & Brezina, "Algebraic multigrid by smoothed aggregation
// for second and fourth order elliptic problems", Computing 56, 1996. Chebyshev smoothing after
// Adams et al., JCP 188, 2003.
#include "math/multigrid.h"

#include <cmath>
#include <string>

#include "math/aggregation.h"

namespace s3 {
namespace {

// θ on the finest level, halved on every coarser one.
constexpr double kStrength = 0.08;
// Degree of the Chebyshev polynomial before and after the coarse correction.
constexpr int kDegree = 2;
// The smoother treats the eigenvalues of M⁻¹A in [1 / kSmoothedShare, 1]; none is larger.
constexpr double kSmoothedShare = 8;
// ω of the prolongation.
constexpr double kOmega = 4.0 / 3.0;
constexpr Eigen::Index kCoarsestRows = 300;
constexpr int kMaxLevels = 20;
// Coarsening that keeps more rows than this share has stalled.
constexpr double kStalled = 0.8;
// Lifts the exact null vectors of a singular coarsest matrix off zero; relative to its diagonal.
constexpr double kLift = 1e-8;

Block constant_vectors(Eigen::Index rows, int block_size) {
  Block vectors = Block::Zero(rows, block_size);
  for (Eigen::Index i = 0; i < rows; ++i) vectors(i, i % block_size) = 1;
  return vectors;
}

[[noreturn]] void bad_size(const std::string& message) {
  throw Error(ErrorKind::slicing, Stage::deformation, "solver.bad_size", message);
}

}  // namespace

void Multigrid::build(const SparseMatrix& A, const Block& near_nullspace, int block_size,
                      Context& ctx) {
  if (block_size < 1 || block_size > kMaxBlock || A.rows() % block_size != 0)
    bad_size("A system of " + std::to_string(A.rows()) + " rows does not fall into blocks of " +
             std::to_string(block_size) + ".");
  Block vectors =
      near_nullspace.size() > 0 ? near_nullspace : constant_vectors(A.rows(), block_size);
  if (vectors.rows() != A.rows() || vectors.cols() > kMaxBlock)
    bad_size("A system of " + std::to_string(A.rows()) + " rows got a near-nullspace of " +
             std::to_string(vectors.rows()) + "×" + std::to_string(vectors.cols()) + ".");
  levels_.clear();
  BlockMatrix<double> matrix = to_blocks(A, block_size);
  double entries = 0;
  double theta = kStrength;
  for (int depth = 0; depth < kMaxLevels; ++depth, theta *= 0.5) {
    const Eigen::Index rows = static_cast<Eigen::Index>(matrix.block_rows()) * matrix.block_height;
    entries += static_cast<double>(matrix.value.size());
    if (rows <= kCoarsestRows) break;
    ctx.checkpoint();
    const std::vector<char> strong = strong_couplings(matrix, theta);
    const Aggregates aggregates = aggregate(matrix, strong);
    if (static_cast<double>(aggregates.count * vectors.cols()) >
        kStalled * static_cast<double>(rows))
      break;
    ctx.checkpoint();
    const BlockMatrix<double> tentative =
        tentative_prolongation(aggregates, matrix.block_height, vectors);
    const std::vector<double> inverse_diagonal = inverse_majorant(matrix);
    const BlockMatrix<double> prolongation =
        smoothed_prolongation(matrix, strong, inverse_diagonal, kOmega, tentative);
    ctx.checkpoint();
    const BlockMatrix<double> restriction = transposed(prolongation);
    const BlockMatrix<double> half = product(matrix, prolongation);
    ctx.checkpoint();
    BlockMatrix<double> coarse = product(restriction, half);
    ctx.checkpoint();

    Level level;
    level.matrix = to_single(matrix);
    level.prolongation = to_single(prolongation);
    level.restriction = to_single(restriction);
    level.inverse_diagonal.assign(inverse_diagonal.begin(), inverse_diagonal.end());
    levels_.push_back(std::move(level));
    matrix = std::move(coarse);
  }
  operator_complexity_ = entries / std::max(1.0, static_cast<double>(A.nonZeros()));
  factor_coarsest(matrix);
}

void Multigrid::factor_coarsest(const BlockMatrix<double>& A) {
  const Eigen::SparseMatrix<double, Eigen::ColMajor, Index> scalars = to_scalars(A);
  Eigen::SparseMatrix<double, Eigen::ColMajor, Index> lifted = scalars;
  Eigen::VectorXd diagonal = scalars.diagonal();
  // Rows of vectors that an aggregate could not hold are empty.
  Eigen::SparseMatrix<double, Eigen::ColMajor, Index> lift(scalars.rows(), scalars.cols());
  lift.setIdentity();
  for (Eigen::Index i = 0; i < diagonal.size(); ++i)
    lift.valuePtr()[i] = diagonal[i] > 0 ? kLift * diagonal[i] : 1.0;
  lifted += lift;
  coarsest_rows_ = lifted.rows();
  coarsest_.compute(lifted);
  if (coarsest_.info() != Eigen::Success)
    throw Error(
        ErrorKind::slicing, Stage::deformation, "solver.not_spd",
        "The linear system is not positive definite: its coarsest level cannot be factored.",
        "Check the mesh for degenerate tets.");
}

void Multigrid::apply(const float* r, float* z, int columns, ThreadPool& pool) const {
  cycle(0, r, z, columns, pool);
}

void Multigrid::cycle(std::size_t depth, const float* b, float* x, int columns,
                      ThreadPool& pool) const {
  if (depth == levels_.size()) return solve_coarsest(b, x, columns);
  const Level& level = levels_[depth];
  const auto n = static_cast<std::size_t>(columns);
  const std::size_t rows = level.matrix.start.size() - 1;
  const std::size_t size = rows * static_cast<std::size_t>(level.matrix.block_height) * n;
  const std::size_t coarse_size = static_cast<std::size_t>(level.prolongation.block_columns) *
                                  static_cast<std::size_t>(level.prolongation.block_width) * n;
  level.direction.resize(size);
  level.spare.resize(size);
  level.b.resize(coarse_size);
  level.x.resize(coarse_size);

  smooth(level, b, x, true, columns, pool);
  residual(level.matrix, b, x, level.direction.data(), columns, pool);
  multiply(level.restriction, level.direction.data(), level.b.data(), columns, pool);
  cycle(depth + 1, level.b.data(), level.x.data(), columns, pool);
  multiply_add(level.prolongation, level.x.data(), x, columns, pool);
  smooth(level, b, x, false, columns, pool);
}

/// kDegree steps of the Chebyshev iteration for eigenvalues of D⁻¹A in [radius / kSmoothedShare,
/// radius].
void Multigrid::smooth(const Level& level, const float* b, float* x, bool from_zero, int columns,
                       ThreadPool& pool) const {
  const double upper = 1, lower = upper / kSmoothedShare;
  const double theta = 0.5 * (upper + lower), delta = 0.5 * (upper - lower);
  const double sigma = theta / delta;
  double rho = 1 / sigma;
  float* now = x;
  float* next = level.spare.data();
  float* d = level.direction.data();
  for (int k = 0; k < kDegree; ++k) {
    double keep = 0, add = 1 / theta;
    if (k > 0) {
      const double rho_next = 1 / (2 * sigma - rho);
      keep = rho_next * rho;
      add = 2 * rho_next / delta;
      rho = rho_next;
    }
    if (k == 0 && from_zero) {
      first_smoothing_step(level.inverse_diagonal, level.matrix.block_height, b, now, d,
                           static_cast<float>(add), columns, pool);
      continue;
    }
    smoothing_step(level.matrix, level.inverse_diagonal, b, now, next, d, static_cast<float>(keep),
                   static_cast<float>(add), columns, pool);
    std::swap(now, next);
  }
  if (now != x) std::copy(now, now + level.spare.size(), x);
}

void Multigrid::solve_coarsest(const float* b, float* x, int columns) const {
  using Columns = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  if (coarsest_rows_ == 0) return;
  const Eigen::Map<const Columns> right(b, coarsest_rows_, columns);
  Eigen::Map<Columns> solution(x, coarsest_rows_, columns);
  solution = coarsest_.solve(Eigen::MatrixXd(right.cast<double>())).cast<float>();
}

}  // namespace s3
