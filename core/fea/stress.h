// The stress field that SR works on: read from a file (read_stress.h) or computed here from load
// cases (Sec. 2.1.2).
#pragma once
#include <vector>

#include "base/context.h"
#include "fea/load_case.h"
#include "fea/material.h"
#include "mesh/tet_mesh.h"

namespace s3 {

struct StressField {
  Tensors stress;          // #T×6 MPa: xx yy zz yz zx xy; empty if only directions are known
  Directions principal;    // #T×3, τ_max: direction of the largest principal stress
  Values principal_value;  // #T MPa, the largest principal stress (tension positive)
  std::vector<Index> critical_tets;  // S: ascending tet indices
};

/// Principal stresses in ascending order, with their directions as columns of a rotation or
/// reflection, each with its largest component positive.
struct PrincipalStresses {
  Vec3 value;
  Mat3 direction;
};
PrincipalStresses principal_stresses(const Vector6& stress);

/// The field of given tensors: τ_max and its value in every tet. S is left empty.
StressField stress_field(Tensors stress, Context& ctx);

/// The isotropic analysis of all load cases on a mesh that stands on the plate. Where there are
/// several, each tet keeps the stress of the case that pulls it most, that with the largest
/// principal stress. S is left empty.
/// @throws Error as apply_load_cases() and solve_elasticity()
StressField analyse_stress(const TetMesh& rest, const LoadCases& file, Context& ctx);

/// Replaces each tet's tensor `passes` times by the mean over its four vertices of their tets'
/// tensors, weighted by volume: linear tets give stress in steps, this takes the steps off and
/// rounds peaks. The mean over the volume stays. A field without tensors is left as it is.
void smooth_stress(const TetMesh& rest, int passes, StressField& field, Context& ctx);

/// S: the tets of largest principal stress, at most `ratio` of all tets by count, and only where it
/// is tension (positive). Ties go to the lower index. Ascending.
std::vector<Index> critical_tets(const Values& principal_value, double ratio);

/// Adds tets to S, where they have a τ_max.
/// @param tets  ascending
void add_critical_tets(const std::vector<Index>& tets, StressField& field);

/// Turns directions and tensors with the mesh: x' = R x.
void rotate_stress(StressField& field, const Mat3& rotation);

}  // namespace s3
