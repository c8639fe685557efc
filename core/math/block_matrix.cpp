#include "math/block_matrix.h"

#include <algorithm>

namespace s3 {

BlockMatrix<double> to_blocks(const SparseMatrix& A, int block_size) {
  BlockMatrix<double> result;
  result.block_height = result.block_width = block_size;
  const auto rows = static_cast<Index>(A.rows() / block_size);
  result.block_columns = rows;
  if (block_size == 1) {
    result.start.assign(A.outerIndexPtr(), A.outerIndexPtr() + A.rows() + 1);
    result.column.assign(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros());
    result.value.assign(A.valuePtr(), A.valuePtr() + A.nonZeros());
    return result;
  }
  std::vector<Index> place(static_cast<std::size_t>(rows), -1);  // of a block column in this row
  for (Index i = 0; i < rows; ++i) {
    const Index first = result.start.back();
    for (int r = 0; r < block_size; ++r)
      for (SparseMatrix::InnerIterator it(A, i * block_size + r); it; ++it) {
        const Index j = static_cast<Index>(it.col()) / block_size;
        if (place[j] < first) {
          place[j] = static_cast<Index>(result.column.size());
          result.column.push_back(j);
          result.value.resize(result.value.size() + result.block_size(), 0.0);
        }
        result.block(place[j])[r * block_size + it.col() % block_size] = it.value();
      }
    result.start.push_back(static_cast<Index>(result.column.size()));
  }
  return result;
}

SparseMatrix to_scalars(const BlockMatrix<double>& A) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  entries.reserve(A.value.size());
  for (Index i = 0; i < A.block_rows(); ++i)
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k)
      for (int r = 0; r < A.block_height; ++r)
        for (int q = 0; q < A.block_width; ++q)
          entries.emplace_back(i * A.block_height + r, A.column[k] * A.block_width + q,
                               A.block(k)[r * A.block_width + q]);
  SparseMatrix result(static_cast<Eigen::Index>(A.block_rows()) * A.block_height,
                      static_cast<Eigen::Index>(A.block_columns) * A.block_width);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

BlockMatrix<float> to_single(const BlockMatrix<double>& A) {
  BlockMatrix<float> result;
  result.block_height = A.block_height;
  result.block_width = A.block_width;
  result.block_columns = A.block_columns;
  result.start = A.start;
  result.column = A.column;
  result.value.assign(A.value.begin(), A.value.end());
  return result;
}

BlockMatrix<double> transposed(const BlockMatrix<double>& A) {
  BlockMatrix<double> result;
  result.block_height = A.block_width;
  result.block_width = A.block_height;
  result.block_columns = A.block_rows();
  result.start.assign(static_cast<std::size_t>(A.block_columns) + 1, 0);
  for (const Index j : A.column) ++result.start[j + 1];
  for (Index j = 0; j < A.block_columns; ++j) result.start[j + 1] += result.start[j];
  result.column.resize(A.column.size());
  result.value.resize(A.value.size());
  std::vector<Index> next(result.start.begin(), result.start.end() - 1);
  for (Index i = 0; i < A.block_rows(); ++i)
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k) {
      const Index place = next[A.column[k]]++;
      result.column[place] = i;
      const double* from = A.block(k);
      double* to = result.block(place);
      for (int r = 0; r < A.block_height; ++r)
        for (int q = 0; q < A.block_width; ++q)
          to[q * A.block_height + r] = from[r * A.block_width + q];
    }
  return result;
}

namespace {

template <int H, int M, int W>
void add_block_product(const double* a, const double* b, double* c, int height, int middle,
                       int width) {
  const int h = H > 0 ? H : height, m = M > 0 ? M : middle, w = W > 0 ? W : width;
  for (int r = 0; r < h; ++r)
    for (int q = 0; q < m; ++q)
      for (int s = 0; s < w; ++s) c[r * w + s] += a[r * m + q] * b[q * w + s];
}

/// Gustavson's row-by-row product; `place` remembers where a column of the current row is.
template <int H, int M, int W>
BlockMatrix<double> product_of(const BlockMatrix<double>& A, const BlockMatrix<double>& B) {
  BlockMatrix<double> C;
  C.block_height = A.block_height;
  C.block_width = B.block_width;
  C.block_columns = B.block_columns;
  C.start.reserve(A.start.size());
  std::vector<Index> place(static_cast<std::size_t>(B.block_columns), -1);
  for (Index i = 0; i < A.block_rows(); ++i) {
    const Index first = C.start.back();
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k) {
      const Index j = A.column[k];
      for (Index l = B.start[j]; l < B.start[j + 1]; ++l) {
        const Index column = B.column[l];
        if (place[column] < first) {
          place[column] = static_cast<Index>(C.column.size());
          C.column.push_back(column);
          C.value.resize(C.value.size() + C.block_size(), 0.0);
        }
        add_block_product<H, M, W>(A.block(k), B.block(l), C.block(place[column]), A.block_height,
                                   A.block_width, B.block_width);
      }
    }
    C.start.push_back(static_cast<Index>(C.column.size()));
  }
  return C;
}

}  // namespace

BlockMatrix<double> product(const BlockMatrix<double>& A, const BlockMatrix<double>& B) {
  const int h = A.block_height, m = A.block_width, w = B.block_width;
  if (h == 1 && m == 1 && w == 1) return product_of<1, 1, 1>(A, B);
  if (h == 1 && m == 1 && w == 4) return product_of<1, 1, 4>(A, B);
  if (h == 4 && m == 1 && w == 4) return product_of<4, 1, 4>(A, B);
  if (h == 4 && m == 4 && w == 4) return product_of<4, 4, 4>(A, B);
  if (h == 3 && m == 3 && w == 6) return product_of<3, 3, 6>(A, B);
  if (h == 6 && m == 3 && w == 6) return product_of<6, 3, 6>(A, B);
  if (h == 6 && m == 6 && w == 6) return product_of<6, 6, 6>(A, B);
  return product_of<0, 0, 0>(A, B);
}

}  // namespace s3
