// Laplacians of fields whose values at neighbouring vertices are compared after a rotation.
#pragma once
#include <array>
#include <vector>

#include "math/sparse_solver.h"

namespace s3 {

/// How the complex number at an edge's first end becomes comparable with the one at its second:
/// turned by `angle`, and mirrored (complex conjugate) where the two ends run opposite ways.
struct Connection {
  Values angle;              // #E rad
  std::vector<char> mirror;  // #E
};

/// The matrix of Σ_e w_e |z_b − T_e z_a|² + Σ_v d_v |z_v|² on (Re, Im) of the #V complex numbers:
/// 2#V×2#V, symmetric, positive semidefinite for w ≥ 0 and d ≥ 0.
SparseMatrix connection_laplacian(const std::vector<std::array<Index, 2>>& ends,
                                  const Values& weight, const Connection& connection,
                                  const Values& diagonal);

/// Adds to the diagonal of such a matrix: d_v to both entries of vertex v.
void add_to_diagonal(SparseMatrix& matrix, const Values& diagonal);

}  // namespace s3
