// Elastic constants of printed materials, with their sources, and the stiffness matrices made of
// them.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "base/types.h"

namespace s3 {

/// Stress or strain as six numbers: xx yy zz yz zx xy, shear strains as γ = 2ε.
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
/// #T×6, one stress or strain a row.
using Tensors = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

/// Constants along the axes of a bead: 1 along it, 2 across it within the layer, 3 along the
/// layer's normal.
struct OrthotropicConstants {
  Vec3 young = Vec3::Zero();    // MPa: Y1, Y2, Y3
  Vec3 poisson = Vec3::Zero();  // ν12, ν13, ν23; ν12: contraction along 2 under a pull along 1
  Vec3 shear = Vec3::Zero();    // MPa: G12, G13, G23
};

struct Material {
  std::string name;
  std::string source;  // where the numbers come from, and what is assumed
  double young = 0;    // MPa, of the isotropic analysis that gives the stress field
  double poisson = 0;
  double density = 0;            // g/cm³
  OrthotropicConstants printed;  // of the verification (Sec. 5.2.3)
};

/// PLA (the paper's constants), PETG, ABS and PA-CF.
std::span<const Material> bundled_materials();

/// Constants of beads that are alike in all directions across them.
///
/// Where nobody measured shear: G23 = Y2 / 2(1 + ν) follows from that symmetry, G12 = G13 =
/// √(Y1 Y2) / 2(1 + √(ν ν')), ν' = ν Y2 / Y1, is Huber's estimate, exact for Y1 = Y2.
OrthotropicConstants bead_constants(double along, double across, double poisson);

/// Stress = stiffness · strain, MPa.
/// @throws Error "fea.bad_material" for constants that no stable material has
Matrix6 isotropic_stiffness(double young, double poisson);
Matrix6 orthotropic_stiffness(const OrthotropicConstants& constants);

/// The stiffness of a material whose directions 1, 2, 3 are the columns of the rotation `axes`.
Matrix6 rotated_stiffness(const Matrix6& stiffness, const Mat3& axes);

}  // namespace s3
