// Smoothed-aggregation multigrid (Vaněk, Mandel & Brezina 1996) in single precision, as a
// preconditioner.
#pragma once
#include <memory>
#include <vector>

#include <Eigen/SparseCholesky>

#include "math/block_matrix.h"
#include "math/conjugate_gradient.h"

namespace s3 {

class Multigrid final : public Preconditioner {
 public:
  /// Builds the hierarchy for A.
  /// @param near_nullspace  n×k: vectors that A nearly annihilates, kept exactly on every level;
  /// empty for one constant
  /// @param block_size      consecutive unknowns that are aggregated together; divides n
  /// @throws Error "solver.bad_size" when the sizes do not fit
  void build(const SparseMatrix& A, const Block& near_nullspace, int block_size, Context& ctx);

  /// One V-cycle from zero.
  void apply(const float* r, float* z, int columns, ThreadPool& pool) const override;

  int levels() const { return static_cast<int>(levels_.size()) + 1; }
  /// Entries of all levels' matrices, relative to the finest.
  double operator_complexity() const { return operator_complexity_; }

 private:
  struct Level {
    BlockMatrix<float> matrix, prolongation, restriction;
    std::vector<float> inverse_diagonal;                // block_rows blocks
    mutable std::vector<float> x, b, direction, spare;  // scratch of apply()
  };

  void cycle(std::size_t level, const float* b, float* x, int columns, ThreadPool& pool) const;
  void smooth(const Level& level, const float* b, float* x, bool from_zero, int columns,
              ThreadPool& pool) const;
  void solve_coarsest(const float* b, float* x, int columns) const;
  void factor_coarsest(const BlockMatrix<double>& A);

  std::vector<Level> levels_;  // all but the coarsest
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double, Eigen::ColMajor, Index>> coarsest_;
  Eigen::Index coarsest_rows_ = 0;
  mutable std::vector<float> coarsest_b_, coarsest_x_;
  double operator_complexity_ = 1;
};

}  // namespace s3
