#include "toolpaths/connection_laplacian.h"

#include <cmath>

namespace s3 {

SparseMatrix connection_laplacian(const std::vector<std::array<Index, 2>>& ends,
                                  const Values& weight, const Connection& connection,
                                  const Values& diagonal) {
  const Eigen::Index n = diagonal.size();
  std::vector<Eigen::Triplet<double, Index>> entries;
  entries.reserve(ends.size() * 8 + static_cast<std::size_t>(n) * 2);
  Values sum = diagonal;
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const auto [a, b] = ends[e];
    const auto row = static_cast<Eigen::Index>(e);
    const double w = weight(row), c = w * std::cos(connection.angle(row)),
                 s = w * std::sin(connection.angle(row)), m = connection.mirror[e] ? -1 : 1;
    sum(a) += w;
    sum(b) += w;
    // T = diag(1, m) · rotation
    const double block[2][2] = {{c, -s}, {m * s, m * c}};
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) {
        entries.emplace_back(2 * b + i, 2 * a + j, -block[i][j]);
        entries.emplace_back(2 * a + j, 2 * b + i, -block[i][j]);
      }
  }
  for (Index v = 0; v < n; ++v)
    for (int i = 0; i < 2; ++i) entries.emplace_back(2 * v + i, 2 * v + i, sum(v));
  SparseMatrix matrix(2 * n, 2 * n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

void add_to_diagonal(SparseMatrix& matrix, const Values& diagonal) {
  for (Eigen::Index v = 0; v < diagonal.size(); ++v)
    for (Eigen::Index i = 0; i < 2; ++i)
      matrix.coeffRef(static_cast<Index>(2 * v + i), static_cast<Index>(2 * v + i)) += diagonal(v);
}

}  // namespace s3
