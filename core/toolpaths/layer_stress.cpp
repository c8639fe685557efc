#include "toolpaths/layer_stress.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace s3 {
namespace {

constexpr double kOutside = 0.05;  // most confidence outside of S

/// (σ₁ − σ₂)/max|σ|: 0 where the direction of the largest principal stress is arbitrary.
double anisotropy(const Eigen::Matrix<double, 6, 1>& s) {
  Mat3 tensor;
  tensor << s(0), s(5), s(4), s(5), s(1), s(3), s(4), s(3), s(2);
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(tensor, Eigen::EigenvaluesOnly);
  const Vec3& value = solver.eigenvalues();  // ascending
  const double largest = std::max(std::abs(value(0)), std::abs(value(2)));
  return largest > 0 ? std::min(1.0, (value(2) - value(1)) / largest) : 0.0;
}

}  // namespace

LayerStress project_stress(const Layer& layer, const StressField& stress) {
  const Eigen::Index n = layer.surface.triangles.rows();
  LayerStress result;
  result.direction.setZero(n, 3);
  result.confidence.setZero(n);
  result.critical.assign(static_cast<std::size_t>(n), 0);
  double least_critical = 0;  // MPa
  for (const Index t : stress.critical_tets)
    least_critical = least_critical > 0 ? std::min(least_critical, stress.principal_value(t))
                                        : stress.principal_value(t);
  for (Eigen::Index f = 0; f < n; ++f) {
    const Index t = layer.source_tet[static_cast<std::size_t>(f)];
    const bool critical =
        std::binary_search(stress.critical_tets.begin(), stress.critical_tets.end(), t);
    result.critical[static_cast<std::size_t>(f)] = critical ? 1 : 0;
    const Vec3 a = layer.surface.vertices.row(layer.surface.triangles(f, 0));
    const Vec3 b = layer.surface.vertices.row(layer.surface.triangles(f, 1));
    const Vec3 c = layer.surface.vertices.row(layer.surface.triangles(f, 2));
    const Vec3 normal = (b - a).cross(c - a).normalized();
    const Vec3 tau = stress.principal.row(t);
    const Vec3 projected = tau - tau.dot(normal) * normal;
    const double squared = projected.squaredNorm();
    if (squared < 1e-12) continue;
    result.direction.row(f) = projected / std::sqrt(squared);
    double confidence = squared;
    if (stress.stress.rows() > 0) confidence *= anisotropy(stress.stress.row(t));
    if (!critical)
      confidence *=
          kOutside *
          std::clamp(stress.principal_value(t) / std::max(least_critical, 1e-300), 0.0, 1.0);
    result.confidence(f) = confidence;
  }
  return result;
}

double critical_share(const Layer& layer, const LayerStress& stress) {
  double area = 0, critical = 0;
  for (Eigen::Index f = 0; f < layer.surface.triangles.rows(); ++f) {
    const Vec3 a = layer.surface.vertices.row(layer.surface.triangles(f, 0));
    const Vec3 b = layer.surface.vertices.row(layer.surface.triangles(f, 1));
    const Vec3 c = layer.surface.vertices.row(layer.surface.triangles(f, 2));
    const double part = 0.5 * (b - a).cross(c - a).norm();
    area += part;
    if (stress.critical[static_cast<std::size_t>(f)]) critical += part;
  }
  return area > 0 ? critical / area : 0;
}

}  // namespace s3
