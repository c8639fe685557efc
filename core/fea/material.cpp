#include "fea/material.h"

#include <array>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "base/error.h"

namespace s3 {
namespace {

Material material(const char* name, double along, double across, double poisson, double density,
                  const char* source) {
  return {name, source, along, poisson, density, bead_constants(along, across, poisson)};
}

[[noreturn]] void bad_material(const std::string& what) {
  throw Error(ErrorKind::input, Stage::fea, "fea.bad_material", "The material " + what + ".",
              "Name a bundled material (PLA, PETG, ABS, PA-CF), or correct its constants.");
}

/// No strain may give back energy.
void check_stable(const Matrix6& compliance) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(compliance, Eigen::EigenvaluesOnly);
  if (!compliance.allFinite() || !(eigen.eigenvalues()[0] > 0))
    bad_material(
        "is not stable: its Young's moduli, Poisson's ratios and shear moduli contradict "
        "each other");
}

}  // namespace

std::span<const Material> bundled_materials() {
  static const std::array<Material, 4> kMaterials = {
      material("PLA", 3500, 1200, 0.35, 1.24,
               "Young's moduli along and across the bead: Zhang et al. 2022, Sec. 5.2.3. Density: "
               "Farah, Anderson and Langer, Adv. Drug Deliv. Rev. 107, 2016. Poisson's ratio 0.35 "
               "and Huber's shear moduli are assumed"),
      material("PETG", 2400, 1900, 0.38, 1.27,
               "In the layer: the middle of the published range of printed PETG, 2 to 3 GPa "
               "(additive.tools/materials/petg), which also gives the density. Across the bead 0.8 "
               "of it is assumed, the ratio of Z to XY in data sheets of printed polyesters; "
               "Poisson's ratio and Huber's shear moduli are assumed"),
      material("ABS", 2390, 1900, 0.35, 1.04,
               "Along the bead: ASTM D638 modulus of 346 ksi and density of extruded ABS "
               "(cctprecision.com/materials/abs). Across the bead 0.8 of it, Poisson's ratio and "
               "Huber's shear moduli are assumed"),
      material("PA-CF", 2400, 1700, 0.4, 1.2,
               "Along the bead and density: Markforged's data sheet of Onyx, nylon with chopped "
               "carbon fibre. Across the bead, where no fibre crosses: its nylon. Poisson's ratio "
               "and Huber's shear moduli are assumed"),
  };
  return kMaterials;
}

OrthotropicConstants bead_constants(double along, double across, double poisson) {
  const double huber =
      std::sqrt(along * across) / (2 * (1 + std::sqrt(poisson * poisson * across / along)));
  return {Vec3(along, across, across), Vec3::Constant(poisson),
          Vec3(huber, huber, across / (2 * (1 + poisson)))};
}

Matrix6 isotropic_stiffness(double young, double poisson) {
  if (!(young > 0 && std::isfinite(young))) bad_material("needs a Young's modulus above 0 MPa");
  if (!(poisson > -1 && poisson < 0.5))
    bad_material("needs a Poisson's ratio above -1 and below 0.5");
  const double mu = young / (2 * (1 + poisson));
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  Matrix6 stiffness = Matrix6::Zero();
  stiffness.topLeftCorner<3, 3>().setConstant(lambda);
  for (int i = 0; i < 3; ++i) {
    stiffness(i, i) += 2 * mu;
    stiffness(i + 3, i + 3) = mu;
  }
  return stiffness;
}

Matrix6 orthotropic_stiffness(const OrthotropicConstants& c) {
  if (!(c.young.minCoeff() > 0 && c.shear.minCoeff() > 0))
    bad_material("needs Young's and shear moduli above 0 MPa");
  const double nu12 = c.poisson[0], nu13 = c.poisson[1], nu23 = c.poisson[2];
  Matrix6 compliance = Matrix6::Zero();
  for (int i = 0; i < 3; ++i) compliance(i, i) = 1 / c.young[i];
  compliance(0, 1) = compliance(1, 0) = -nu12 / c.young[0];
  compliance(0, 2) = compliance(2, 0) = -nu13 / c.young[0];
  compliance(1, 2) = compliance(2, 1) = -nu23 / c.young[1];
  compliance(3, 3) = 1 / c.shear[2];
  compliance(4, 4) = 1 / c.shear[1];
  compliance(5, 5) = 1 / c.shear[0];
  check_stable(compliance);
  return compliance.inverse();
}

Matrix6 rotated_stiffness(const Matrix6& stiffness, const Mat3& axes) {
  // Strain along the material's axes: E' = Qᵀ E Q, written for the six numbers.
  constexpr int kFirst[6] = {0, 1, 2, 1, 2, 0}, kSecond[6] = {0, 1, 2, 2, 0, 1};
  Matrix6 turn;
  for (int row = 0; row < 6; ++row) {
    const Vec3 p = axes.col(kFirst[row]), q = axes.col(kSecond[row]);
    const double factor = row < 3 ? 0.5 : 1;
    for (int column = 0; column < 6; ++column) {
      const int a = kFirst[column], b = kSecond[column];
      turn(row, column) = factor * (column < 3 ? 2 * p[a] * q[a] : p[a] * q[b] + p[b] * q[a]);
    }
  }
  return turn.transpose() * stiffness * turn;
}

}  // namespace s3
