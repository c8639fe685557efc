#include "math/aggregation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <Eigen/Cholesky>

namespace s3 {
namespace {

using DynamicBlock =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxBlock, kMaxBlock>;

// A column that loses all but this share of its length to the ones before it is dependent on them.
constexpr double kDependent = 1e-7;

double squared_norm(const double* block, std::size_t size) {
  double sum = 0;
  for (std::size_t k = 0; k < size; ++k) sum += block[k] * block[k];
  return sum;
}

Index diagonal_place(const BlockMatrix<double>& A, Index i) {
  for (Index k = A.start[i]; k < A.start[i + 1]; ++k)
    if (A.column[k] == i) return k;
  return -1;
}

double coupling(const BlockMatrix<double>& A, Index k) {
  return squared_norm(A.block(k), A.block_size());
}

/// First pass: every row whose strong neighbours are all free starts an aggregate with them.
void aggregate_neighbourhoods(const BlockMatrix<double>& A, const std::vector<char>& strong,
                              Aggregates& result) {
  for (Index i = 0; i < A.block_rows(); ++i) {
    bool free = result.of[i] < 0;
    for (Index k = A.start[i]; free && k < A.start[i + 1]; ++k)
      if (strong[k] && result.of[A.column[k]] >= 0) free = false;
    if (!free) continue;
    result.of[i] = result.count;
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k)
      if (strong[k]) result.of[A.column[k]] = result.count;
    ++result.count;
  }
}

/// Second pass: a row that is left joins the neighbouring aggregate of its strongest coupling.
void join_strongest(const BlockMatrix<double>& A, const std::vector<char>& strong,
                    Aggregates& result) {
  const std::vector<Index> before = result.of;
  for (Index i = 0; i < A.block_rows(); ++i) {
    if (before[i] >= 0) continue;
    double strongest = -1;
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k)
      if (strong[k] && before[A.column[k]] >= 0 && coupling(A, k) > strongest) {
        strongest = coupling(A, k);
        result.of[i] = before[A.column[k]];
      }
  }
}

/// Third pass: what is still left forms aggregates with its free neighbours.
void aggregate_rest(const BlockMatrix<double>& A, const std::vector<char>& strong,
                    Aggregates& result) {
  for (Index i = 0; i < A.block_rows(); ++i) {
    if (result.of[i] >= 0) continue;
    result.of[i] = result.count;
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k)
      if (strong[k] && result.of[A.column[k]] < 0) result.of[A.column[k]] = result.count;
    ++result.count;
  }
}

/// Orthonormalises the columns of Q in place (modified Gram-Schmidt, twice) and returns R with Q R
/// = the old Q.
DynamicBlock orthonormalize(Eigen::MatrixXd& Q) {
  const Eigen::Index k = Q.cols();
  DynamicBlock R = DynamicBlock::Zero(k, k);
  for (Eigen::Index c = 0; c < k; ++c) {
    const double before = Q.col(c).norm();
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index a = 0; a < c; ++a) {
        const double projection = Q.col(a).dot(Q.col(c));
        R(a, c) += projection;
        Q.col(c) -= projection * Q.col(a);
      }
    const double length = Q.col(c).norm();
    if (length > kDependent * before) {
      R(c, c) = length;
      Q.col(c) /= length;
    } else {
      Q.col(c).setZero();
    }
  }
  return R;
}

/// The rows of every aggregate, grouped.
struct Members {
  std::vector<Index> start, row;
};

Members members_of(const Aggregates& aggregates) {
  Members members;
  members.start.assign(static_cast<std::size_t>(aggregates.count) + 1, 0);
  for (const Index a : aggregates.of) ++members.start[a + 1];
  for (Index a = 0; a < aggregates.count; ++a) members.start[a + 1] += members.start[a];
  members.row.resize(aggregates.of.size());
  std::vector<Index> next(members.start.begin(), members.start.end() - 1);
  for (Index i = 0; i < static_cast<Index>(aggregates.of.size()); ++i)
    members.row[next[aggregates.of[i]]++] = i;
  return members;
}

/// Lower triangular L with L Lᵀ = D; a D that is not positive definite is replaced by its diagonal,
/// zeros there by one.
DynamicBlock diagonal_factor(const double* block, int b) {
  DynamicBlock D = DynamicBlock::Zero(b, b);
  if (block != nullptr) D = Eigen::Map<const DynamicBlock>(block, b, b);
  for (int r = 0; r < b; ++r)
    if (!(D(r, r) > 0)) {
      D.row(r).setZero();
      D.col(r).setZero();
      D(r, r) = 1;
    }
  const Eigen::LLT<DynamicBlock> factor(D);
  if (factor.info() == Eigen::Success) return factor.matrixL();
  return D.diagonal().cwiseSqrt().asDiagonal();
}

/// An upper bound of the largest singular value.
double norm_bound(const DynamicBlock& M) {
  const double columns = M.cwiseAbs().colwise().sum().maxCoeff();
  const double rows = M.cwiseAbs().rowwise().sum().maxCoeff();
  return std::min(M.norm(), std::sqrt(columns * rows));
}

std::vector<double> inverse_majorant_of_scalars(const BlockMatrix<double>& A) {
  const auto n = static_cast<std::size_t>(A.block_rows());
  std::vector<double> root(n, 1.0), inverse(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Index k = diagonal_place(A, static_cast<Index>(i));
    if (k >= 0 && A.value[k] > 0) root[i] = 1 / std::sqrt(A.value[k]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0;
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k)
      sum += std::abs(A.value[k]) * root[A.column[k]];
    inverse[i] = sum > 0 ? root[i] / sum : 1;
  }
  return inverse;
}

}  // namespace

std::vector<char> strong_couplings(const BlockMatrix<double>& A, double theta) {
  std::vector<double> diagonal(static_cast<std::size_t>(A.block_rows()), 0.0);
  for (Index i = 0; i < A.block_rows(); ++i)
    if (const Index k = diagonal_place(A, i); k >= 0) diagonal[i] = std::sqrt(coupling(A, k));
  std::vector<char> strong(A.column.size(), 0);
  const double theta_squared = theta * theta;
  for (Index i = 0; i < A.block_rows(); ++i)
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k) {
      const Index j = A.column[k];
      strong[k] = j != i && coupling(A, k) > theta_squared * diagonal[i] * diagonal[j];
    }
  return strong;
}

Aggregates aggregate(const BlockMatrix<double>& A, const std::vector<char>& strong) {
  Aggregates result;
  result.of.assign(static_cast<std::size_t>(A.block_rows()), -1);
  aggregate_neighbourhoods(A, strong, result);
  join_strongest(A, strong, result);
  aggregate_rest(A, strong, result);
  return result;
}

BlockMatrix<double> tentative_prolongation(const Aggregates& aggregates, int block_height,
                                           Block& near_nullspace) {
  const auto k = static_cast<int>(near_nullspace.cols());
  BlockMatrix<double> T;
  T.block_height = block_height;
  T.block_width = k;
  T.block_columns = aggregates.count;
  T.column = aggregates.of;
  T.start.resize(aggregates.of.size() + 1);
  for (std::size_t i = 0; i < T.start.size(); ++i) T.start[i] = static_cast<Index>(i);
  T.value.resize(T.column.size() * T.block_size());

  const Members members = members_of(aggregates);
  Block coarse = Block::Zero(static_cast<Eigen::Index>(aggregates.count) * k, k);
  Eigen::MatrixXd Q;
  for (Index a = 0; a < aggregates.count; ++a) {
    const Index first = members.start[a], count = members.start[a + 1] - first;
    Q.resize(static_cast<Eigen::Index>(count) * block_height, k);
    for (Index m = 0; m < count; ++m)
      Q.middleRows(m * block_height, block_height) =
          near_nullspace.middleRows(members.row[first + m] * block_height, block_height);
    coarse.middleRows(a * k, k) = orthonormalize(Q);
    for (Index m = 0; m < count; ++m) {
      double* block = T.block(members.row[first + m]);
      for (int r = 0; r < block_height; ++r)
        for (int c = 0; c < k; ++c) block[r * k + c] = Q(m * block_height + r, c);
    }
  }
  near_nullspace = std::move(coarse);
  return T;
}

std::vector<double> inverse_majorant(const BlockMatrix<double>& A) {
  const int b = A.block_height;
  if (b == 1) return inverse_majorant_of_scalars(A);
  std::vector<DynamicBlock> inverse_factor;
  inverse_factor.reserve(static_cast<std::size_t>(A.block_rows()));
  for (Index i = 0; i < A.block_rows(); ++i) {
    const Index k = diagonal_place(A, i);
    const DynamicBlock L = diagonal_factor(k >= 0 ? A.block(k) : nullptr, b);
    inverse_factor.push_back(L.triangularView<Eigen::Lower>().solve(DynamicBlock::Identity(b, b)));
  }
  std::vector<double> inverse(static_cast<std::size_t>(A.block_rows()) * A.block_size());
  for (Index i = 0; i < A.block_rows(); ++i) {
    double sum = 0;
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k) {
      const Eigen::Map<const DynamicBlock> block(A.block(k), b, b);
      if (A.column[k] == i)
        sum += 1;
      else
        sum += norm_bound(inverse_factor[i] * block * inverse_factor[A.column[k]].transpose());
    }
    Eigen::Map<DynamicBlock>(inverse.data() + static_cast<std::size_t>(i) * A.block_size(), b, b) =
        inverse_factor[i].transpose() * inverse_factor[i] / std::max(1.0, sum);
  }
  return inverse;
}

BlockMatrix<double> smoothed_prolongation(const BlockMatrix<double>& A,
                                          const std::vector<char>& strong,
                                          const std::vector<double>& inverse_majorant, double omega,
                                          const BlockMatrix<double>& T) {
  const int b = A.block_height, w = T.block_width;
  BlockMatrix<double> P;
  P.block_height = b;
  P.block_width = w;
  P.block_columns = T.block_columns;
  P.start.reserve(T.start.size());
  std::vector<Index> place(static_cast<std::size_t>(T.block_columns), -1);
  std::vector<double> lumped(A.block_size()), scaled(P.block_size());
  for (Index i = 0; i < A.block_rows(); ++i) {
    const Index first = P.start.back();
    const auto add = [&](const double* a, Index j) {
      const Index column = T.column[j];
      if (place[column] < first) {
        place[column] = static_cast<Index>(P.column.size());
        P.column.push_back(column);
        P.value.resize(P.value.size() + P.block_size(), 0.0);
      }
      double* out = P.block(place[column]);
      for (int r = 0; r < b; ++r)
        for (int q = 0; q < b; ++q)
          for (int c = 0; c < w; ++c) out[r * w + c] += a[r * b + q] * T.block(j)[q * w + c];
    };
    std::fill(lumped.begin(), lumped.end(), 0.0);
    for (Index k = A.start[i]; k < A.start[i + 1]; ++k) {
      if (strong[k])
        add(A.block(k), A.column[k]);
      else
        for (std::size_t e = 0; e < lumped.size(); ++e) lumped[e] += A.block(k)[e];
    }
    add(lumped.data(), i);
    // What is there now is A_F T; the row becomes T − ω M⁻¹ A_F T.
    const double* inverse = inverse_majorant.data() + static_cast<std::size_t>(i) * A.block_size();
    for (Index k = first; k < static_cast<Index>(P.column.size()); ++k) {
      double* out = P.block(k);
      for (int r = 0; r < b; ++r)
        for (int c = 0; c < w; ++c) {
          double sum = 0;
          for (int q = 0; q < b; ++q) sum += inverse[r * b + q] * out[q * w + c];
          scaled[r * w + c] = -omega * sum;
        }
      const double* own = P.column[k] == T.column[i] ? T.block(i) : nullptr;
      for (std::size_t e = 0; e < scaled.size(); ++e) out[e] = scaled[e] + (own ? own[e] : 0);
    }
    P.start.push_back(static_cast<Index>(P.column.size()));
  }
  return P;
}

}  // namespace s3
