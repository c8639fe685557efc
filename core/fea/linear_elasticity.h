// Linear elasticity K u = f on linear tets, isotropic or orthotropic with a frame in every tet
// (Sec. 2.1.2, 5.2.3).
#pragma once
#include <vector>

#include "base/context.h"
#include "fea/loading.h"
#include "fea/material.h"
#include "mesh/tet_mesh.h"

namespace s3 {

/// What the tets are made of.
struct ElasticBody {
  Matrix6 stiffness = Matrix6::Zero();  // MPa, along the axes of a frame
  std::vector<Mat3>
      frame;  // #T rotations, their columns the axes 1, 2, 3; empty for the mesh's own

  /// The stiffness of a tet in the mesh's axes.
  Matrix6 of_tet(Index t) const {
    return frame.empty() ? stiffness
                         : rotated_stiffness(stiffness, frame[static_cast<std::size_t>(t)]);
  }
};

struct ElasticSolverOptions {
  double tolerance = 1e-8;  // ‖f − K u‖ ≤ tolerance·‖f‖ over the free axes
  int max_iterations = 2000;
};

/// Displacements #V×3, mm, one for each loading. Loadings with the same held axes share one matrix
/// and one multigrid hierarchy, kept on the six rigid-body modes. Vertices of no tet do not move.
///
/// The loadings must hold the part (apply_load_cases() checks that).
/// @throws Error "fea.no_convergence"; Cancelled
std::vector<Points> solve_elasticity(const TetMesh& mesh, const ElasticBody& body,
                                     const std::vector<Loading>& loadings,
                                     const ElasticSolverOptions& options, Context& ctx);

/// The strain of every tet under displacements: xx yy zz yz zx xy, shear as γ = 2ε.
Tensors strains(const TetMesh& mesh, const Points& displacement, Context& ctx);
/// The stress of every tet, MPa.
Tensors stresses(const ElasticBody& body, const Tensors& strains, Context& ctx);

}  // namespace s3
