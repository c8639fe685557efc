// The passes of the V-cycle. Block edges and column counts that occur often are known to the
// compiler; 0 stands for "look it up".
#include <array>

#include "math/block_matrix.h"

namespace s3 {
namespace {

constexpr std::size_t kGrain = 2048;  // block rows

using Accumulator = std::array<float, kMaxBlock * 4>;

/// sum (height×N) += row i of A times x
template <int H, int W, int N>
void add_row_product(const BlockMatrix<float>& A, std::size_t i, const float* x, float* sum) {
  const int height = H > 0 ? H : A.block_height, width = W > 0 ? W : A.block_width;
  const Index end = A.start[i + 1];
  const float* block = A.block(A.start[i]);
  for (Index k = A.start[i]; k < end; ++k, block += height * width) {
    const float* in = x + static_cast<std::size_t>(A.column[static_cast<std::size_t>(k)]) *
                              static_cast<std::size_t>(width * N);
    for (int r = 0; r < height; ++r)
      for (int q = 0; q < width; ++q)
        for (int c = 0; c < N; ++c) sum[r * N + c] += block[r * width + q] * in[q * N + c];
  }
}

template <int H, int W, class Pass>
void with_columns(int columns, Pass&& pass) {
  switch (columns) {
    case 1:
      return pass.template operator()<H, W, 1>();
    case 2:
      return pass.template operator()<H, W, 2>();
    case 3:
      return pass.template operator()<H, W, 3>();
    default:
      return pass.template operator()<H, W, 4>();
  }
}

template <class Pass>
void with_square_blocks(int edge, int columns, Pass&& pass) {
  switch (edge) {
    case 1:
      return with_columns<1, 1>(columns, pass);
    case 3:
      return with_columns<3, 3>(columns, pass);
    case 4:
      return with_columns<4, 4>(columns, pass);
    case 6:
      return with_columns<6, 6>(columns, pass);
    default:
      return with_columns<0, 0>(columns, pass);
  }
}

template <class Pass>
void with_blocks(int height, int width, int columns, Pass&& pass) {
  if (height == width) return with_square_blocks(height, columns, pass);
  if (height == 1 && width == 4) return with_columns<1, 4>(columns, pass);
  if (height == 4 && width == 1) return with_columns<4, 1>(columns, pass);
  if (height == 3 && width == 6) return with_columns<3, 6>(columns, pass);
  if (height == 6 && width == 3) return with_columns<6, 3>(columns, pass);
  return with_columns<0, 0>(columns, pass);
}

/// Calls row(i, sum) for every block row, sum starting at the row's values of `from` (or zero) plus
/// A x.
template <int H, int W, int N, class Row>
void for_rows(const BlockMatrix<float>& A, const float* x, ThreadPool& pool, Row&& row) {
  const auto size = static_cast<std::size_t>((H > 0 ? H : A.block_height) * N);
  parallel_for(pool, static_cast<std::size_t>(A.block_rows()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 Accumulator sum;
                 for (std::size_t i = begin; i < end; ++i) {
                   for (std::size_t k = 0; k < size; ++k) sum[k] = 0;
                   add_row_product<H, W, N>(A, i, x, sum.data());
                   row(i * size, size, sum.data());
                 }
               });
}

/// out (edge×N) = D⁻¹ in for one block of D
template <int E, int N>
void block_times(const float* inverse, int edge_if_unknown, const float* in, float* out) {
  const int edge = E > 0 ? E : edge_if_unknown;
  for (int r = 0; r < edge; ++r)
    for (int c = 0; c < N; ++c) {
      float sum = 0;
      for (int q = 0; q < edge; ++q) sum += inverse[r * edge + q] * in[q * N + c];
      out[r * N + c] = sum;
    }
}

}  // namespace

void multiply(const BlockMatrix<float>& A, const float* x, float* y, int columns,
              ThreadPool& pool) {
  with_blocks(A.block_height, A.block_width, columns, [&]<int H, int W, int N>() {
    for_rows<H, W, N>(A, x, pool, [&](std::size_t at, std::size_t size, const float* sum) {
      for (std::size_t k = 0; k < size; ++k) y[at + k] = sum[k];
    });
  });
}

void multiply_add(const BlockMatrix<float>& A, const float* x, float* y, int columns,
                  ThreadPool& pool) {
  with_blocks(A.block_height, A.block_width, columns, [&]<int H, int W, int N>() {
    for_rows<H, W, N>(A, x, pool, [&](std::size_t at, std::size_t size, const float* sum) {
      for (std::size_t k = 0; k < size; ++k) y[at + k] += sum[k];
    });
  });
}

void residual(const BlockMatrix<float>& A, const float* b, const float* x, float* r, int columns,
              ThreadPool& pool) {
  with_square_blocks(A.block_height, columns, [&]<int H, int W, int N>() {
    for_rows<H, W, N>(A, x, pool, [&](std::size_t at, std::size_t size, const float* sum) {
      for (std::size_t k = 0; k < size; ++k) r[at + k] = b[at + k] - sum[k];
    });
  });
}

void smoothing_step(const BlockMatrix<float>& A, const std::vector<float>& inverse_diagonal,
                    const float* b, const float* x, float* x_next, float* d, float c_d, float c_r,
                    int columns, ThreadPool& pool) {
  with_square_blocks(A.block_height, columns, [&]<int H, int W, int N>() {
    const int edge = H > 0 ? H : A.block_height;
    for_rows<H, W, N>(A, x, pool, [&](std::size_t at, std::size_t size, const float* sum) {
      Accumulator r, correction;
      for (std::size_t k = 0; k < size; ++k) r[k] = b[at + k] - sum[k];
      block_times<H, N>(inverse_diagonal.data() + at / N * static_cast<std::size_t>(edge), edge,
                        r.data(), correction.data());
      for (std::size_t k = 0; k < size; ++k) {
        const float step = c_d * d[at + k] + c_r * correction[k];
        d[at + k] = step;
        x_next[at + k] = x[at + k] + step;
      }
    });
  });
}

void first_smoothing_step(const std::vector<float>& inverse_diagonal, int block, const float* b,
                          float* x, float* d, float c_r, int columns, ThreadPool& pool) {
  with_square_blocks(block, columns, [&]<int E, int, int N>() {
    const auto edge = static_cast<std::size_t>(E > 0 ? E : block);
    parallel_for(pool, inverse_diagonal.size() / (edge * edge), kGrain,
                 [&](std::size_t begin, std::size_t end) {
                   Accumulator correction;
                   for (std::size_t i = begin; i < end; ++i) {
                     const std::size_t at = i * edge * N;
                     block_times<E, N>(inverse_diagonal.data() + i * edge * edge, block, b + at,
                                       correction.data());
                     for (std::size_t k = 0; k < edge * N; ++k) {
                       d[at + k] = c_r * correction[k];
                       x[at + k] = d[at + k];
                     }
                   }
                 });
  });
}

}  // namespace s3
