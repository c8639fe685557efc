// The matrix behind every term that compares a tet with its face neighbours (Eqs. 8 and 12).
#pragma once
#include "base/types.h"
#include "math/sparse_solver.h"
#include "mesh/tet_mesh.h"

namespace s3 {

/// Σ over face pairs of w ‖u_i − u_j‖² plus Σ_t diagonal_t u_t², as a #T×#T matrix.
/// @param weight    #N, w of each of mesh.face_pairs
/// @param diagonal  #T
SparseMatrix face_laplacian(const TetMesh& mesh, const Values& weight, const Values& diagonal);

}  // namespace s3
