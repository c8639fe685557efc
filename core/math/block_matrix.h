// Sparse matrices of small dense blocks, row by row, for the multigrid hierarchy.
#pragma once
#include <cstddef>
#include <vector>

#include "base/parallel.h"
#include "base/types.h"
#include "math/sparse_solver.h"

namespace s3 {

/// The largest block edge: six rigid-body modes and room for more.
inline constexpr int kMaxBlock = 12;

/// block_rows() rows of block_height×block_width blocks. Columns of a row are in no particular, but
/// fixed, order.
template <class Real>
struct BlockMatrix {
  int block_height = 1, block_width = 1;
  Index block_columns = 0;
  std::vector<Index> start = {0};  // #block rows + 1
  std::vector<Index> column;       // block column of every block
  std::vector<Real> value;         // blocks, row-major

  Index block_rows() const { return static_cast<Index>(start.size()) - 1; }
  std::size_t block_size() const {
    return static_cast<std::size_t>(block_height) * static_cast<std::size_t>(block_width);
  }
  const Real* block(Index k) const {
    return value.data() + static_cast<std::size_t>(k) * block_size();
  }
  Real* block(Index k) { return value.data() + static_cast<std::size_t>(k) * block_size(); }
};

/// A with its unknowns grouped by block_size, which divides A.rows().
BlockMatrix<double> to_blocks(const SparseMatrix& A, int block_size);
SparseMatrix to_scalars(const BlockMatrix<double>& A);
BlockMatrix<float> to_single(const BlockMatrix<double>& A);
BlockMatrix<double> transposed(const BlockMatrix<double>& A);
BlockMatrix<double> product(const BlockMatrix<double>& A, const BlockMatrix<double>& B);

// Passes over a matrix with 1…4 interleaved columns. Vectors are (#rows)×columns, row-major.

/// y = A x
void multiply(const BlockMatrix<float>& A, const float* x, float* y, int columns, ThreadPool& pool);
/// y += A x
void multiply_add(const BlockMatrix<float>& A, const float* x, float* y, int columns,
                  ThreadPool& pool);
/// r = b − A x
void residual(const BlockMatrix<float>& A, const float* b, const float* x, float* r, int columns,
              ThreadPool& pool);
/// d = c_d·d + c_r·D⁻¹(b − A x), x_next = x + d; x_next must not be x.
void smoothing_step(const BlockMatrix<float>& A, const std::vector<float>& inverse_diagonal,
                    const float* b, const float* x, float* x_next, float* d, float c_d, float c_r,
                    int columns, ThreadPool& pool);
/// d = c_r·D⁻¹ b, x = d: the first smoothing step from zero. `block` is the edge of D's blocks.
void first_smoothing_step(const std::vector<float>& inverse_diagonal, int block, const float* b,
                          float* x, float* d, float c_r, int columns, ThreadPool& pool);

}  // namespace s3
