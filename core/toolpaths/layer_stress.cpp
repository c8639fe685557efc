#include "toolpaths/layer_stress.h"

#include <algorithm>
#include <cmath>

#include "fea/stress.h"
#include "mesh/tri_mesh.h"

namespace s3 {
namespace {

constexpr double kOutside = 0.05;  // most confidence outside of S

/// (σ₁ − σ₂)/max|σ|: 0 where the direction of the largest principal stress is arbitrary.
double anisotropy(const Vector6& stress) {
  const Vec3 value = principal_stresses(stress).value;  // ascending
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
    const Vec3 normal =
        triangle_normal_2a(layer.surface.vertices, layer.surface.triangles.row(f)).normalized();
    const Vec3 tau = stress.principal.row(t);
    const Vec3 projected = tau - tau.dot(normal) * normal;
    const double squared = projected.squaredNorm();
    if (squared < 1e-12) continue;
    result.direction.row(f) = projected / std::sqrt(squared);
    double confidence = squared;
    if (stress.stress.rows() > 0) confidence *= anisotropy(stress.stress.row(t).transpose());
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
    const double part =
        0.5 * triangle_normal_2a(layer.surface.vertices, layer.surface.triangles.row(f)).norm();
    area += part;
    if (stress.critical[static_cast<std::size_t>(f)]) critical += part;
  }
  return area > 0 ? critical / area : 0;
}

}  // namespace s3
