// Coarsening for multigrid: groups of strongly coupled unknowns, and the interpolation between
// groups and unknowns.
#pragma once
#include <vector>

#include "math/block_matrix.h"

namespace s3 {

/// One flag a block of A: the coupling ‖A_ij‖² > θ²‖A_ii‖‖A_jj‖ is strong. Diagonal blocks are not.
std::vector<char> strong_couplings(const BlockMatrix<double>& A, double theta);

struct Aggregates {
  std::vector<Index> of;  // the aggregate of every block row
  Index count = 0;
};

/// Disjoint neighbourhoods of strongly coupled block rows, in the order of their first rows. Rows
/// without strong couplings stay alone.
Aggregates aggregate(const BlockMatrix<double>& A, const std::vector<char>& strong);

/// The piecewise near-nullspace: block-diagonal over aggregates, orthonormal columns (QR of each
/// aggregate's rows). Where an aggregate has fewer independent rows than vectors, columns are zero.
/// @param near_nullspace  rows×k, row-major; replaced by the coarse one, so that P·coarse = fine
BlockMatrix<double> tentative_prolongation(const Aggregates& aggregates, int block_height,
                                           Block& near_nullspace);

/// Inverses of A's diagonal blocks D_i, each divided by s_i = Σ_j ‖L_i⁻¹ A_ij L_j⁻ᵀ‖, D_i = L_i
/// L_iᵀ: A is nowhere larger than the block-diagonal matrix of s_i D_i (Gershgorin), whatever the
/// shape of the tets. Empty rows of A get the identity.
std::vector<double> inverse_majorant(const BlockMatrix<double>& A);

/// P = (I − ω M⁻¹ A_F) T, where A_F is A with its weak couplings lumped into the diagonal.
BlockMatrix<double> smoothed_prolongation(const BlockMatrix<double>& A,
                                          const std::vector<char>& strong,
                                          const std::vector<double>& inverse_majorant, double omega,
                                          const BlockMatrix<double>& tentative);

}  // namespace s3
