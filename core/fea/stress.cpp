#include "fea/stress.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "fea/linear_elasticity.h"
#include "fea/loading.h"

namespace s3 {
namespace {

constexpr std::size_t kGrain = 2048;  // tets

Mat3 matrix_of(const Vector6& s) {
  Mat3 tensor;
  tensor << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
  return tensor;
}

/// Keeps the tensors of `other` where they pull more.
void take_larger(StressField& field, const StressField& other) {
  for (Eigen::Index t = 0; t < field.principal_value.size(); ++t) {
    if (other.principal_value[t] <= field.principal_value[t]) continue;
    field.stress.row(t) = other.stress.row(t);
    field.principal.row(t) = other.principal.row(t);
    field.principal_value[t] = other.principal_value[t];
  }
}

Tensors smoothed(const TetMesh& rest, const Values& volume, const Tensors& stress) {
  Tensors at_vertex = Tensors::Zero(rest.vertex_count(), 6);
  Values weight = Values::Zero(rest.vertex_count());
  for (Index t = 0; t < rest.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) {
      at_vertex.row(rest.tets(t, i)) += volume[t] * stress.row(t);
      weight[rest.tets(t, i)] += volume[t];
    }
  Tensors result(rest.tet_count(), 6);
  for (Index t = 0; t < rest.tet_count(); ++t) {
    Vector6 mean = Vector6::Zero();
    for (int i = 0; i < 4; ++i)
      mean += 0.25 / weight[rest.tets(t, i)] * at_vertex.row(rest.tets(t, i)).transpose();
    result.row(t) = mean.transpose();
  }
  return result;
}

}  // namespace

PrincipalStresses principal_stresses(const Vector6& stress) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(matrix_of(stress));
  PrincipalStresses result{eigen.eigenvalues(), eigen.eigenvectors()};
  for (int i = 0; i < 3; ++i) {
    Eigen::Index largest = 0;
    result.direction.col(i).cwiseAbs().maxCoeff(&largest);
    if (result.direction(largest, i) < 0) result.direction.col(i) *= -1;
  }
  return result;
}

StressField stress_field(Tensors stress, Context& ctx) {
  StressField field;
  field.stress = std::move(stress);
  field.principal.resize(field.stress.rows(), 3);
  field.principal_value.resize(field.stress.rows());
  parallel_for(ctx.pool, static_cast<std::size_t>(field.stress.rows()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = begin; i < end; ++i) {
                   const auto t = static_cast<Eigen::Index>(i);
                   const PrincipalStresses p = principal_stresses(field.stress.row(t).transpose());
                   field.principal.row(t) = p.direction.col(2).transpose();
                   field.principal_value[t] = p.value[2];
                 }
               });
  return field;
}

StressField analyse_stress(const TetMesh& rest, const LoadCases& file, Context& ctx) {
  ElasticBody body;
  body.stiffness = isotropic_stiffness(file.material.young, file.material.poisson);
  const std::vector<Loading> loadings = apply_load_cases(rest, file, ctx);
  const std::vector<Points> displacements = solve_elasticity(rest, body, loadings, {}, ctx);
  StressField envelope;
  for (std::size_t l = 0; l < loadings.size(); ++l) {
    ctx.checkpoint();
    StressField field =
        stress_field(stresses(body, strains(rest, displacements[l], ctx), ctx), ctx);
    if (l == 0)
      envelope = std::move(field);
    else
      take_larger(envelope, field);
  }
  return envelope;
}

void smooth_stress(const TetMesh& rest, int passes, StressField& field, Context& ctx) {
  if (passes <= 0 || field.stress.rows() == 0) return;
  const Values volume = tet_volumes(rest);
  Tensors stress = field.stress;
  for (int pass = 0; pass < passes; ++pass) {
    ctx.checkpoint();
    stress = smoothed(rest, volume, stress);
  }
  field = stress_field(std::move(stress), ctx);
}

std::vector<Index> critical_tets(const Values& principal_value, double ratio) {
  std::vector<Index> tets;
  for (Eigen::Index t = 0; t < principal_value.size(); ++t)
    if (principal_value[t] > 0) tets.push_back(static_cast<Index>(t));
  const auto wanted = static_cast<std::size_t>(
      std::floor(std::clamp(ratio, 0.0, 1.0) * static_cast<double>(principal_value.size()) + 1e-9));
  if (wanted < tets.size()) {
    const auto border = tets.begin() + static_cast<std::ptrdiff_t>(wanted);
    std::nth_element(tets.begin(), border, tets.end(), [&](Index a, Index b) {
      return principal_value[a] != principal_value[b] ? principal_value[a] > principal_value[b]
                                                      : a < b;
    });
    tets.erase(border, tets.end());
    std::sort(tets.begin(), tets.end());
  }
  return tets;
}

void add_critical_tets(const std::vector<Index>& tets, StressField& field) {
  std::vector<Index> directed, all;
  for (const Index t : tets)
    if (field.principal.row(t).squaredNorm() > 0) directed.push_back(t);
  std::set_union(field.critical_tets.begin(), field.critical_tets.end(), directed.begin(),
                 directed.end(), std::back_inserter(all));
  field.critical_tets = std::move(all);
}

void rotate_stress(StressField& field, const Mat3& rotation) {
  field.principal = (field.principal * rotation.transpose()).eval();
  for (Eigen::Index t = 0; t < field.stress.rows(); ++t) {
    const auto s = field.stress.row(t);
    const Mat3 turned = rotation * matrix_of(s.transpose()) * rotation.transpose();
    field.stress.row(t) << turned(0, 0), turned(1, 1), turned(2, 2), turned(1, 2), turned(0, 2),
        turned(0, 1);
  }
}

}  // namespace s3
