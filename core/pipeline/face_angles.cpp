#include "pipeline/face_angles.h"

#include <cmath>

#include "base/units.h"
#include "quaternion_field/concavity_weights.h"

namespace s3 {
namespace {

constexpr double kQualityDeg = 10;        // as in the metrics
constexpr double kAngleTolerance = 1e-6;  // degrees: a face at exactly 45° is no overhang

Vec3 shared_face_centroid(const TetMesh& mesh, Eigen::Index pair) {
  const Index t = mesh.face_pairs(pair, 0);
  const auto& corners = kTetFaces.at(static_cast<std::size_t>(mesh.face_pair_local(pair, 0)));
  return (mesh.corner(t, corners[0]) + mesh.corner(t, corners[1]) + mesh.corner(t, corners[2])) / 3;
}

}  // namespace

FaceAngles face_angles(const Artifacts& artifacts, const Params& params,
                       const Directions& print_direction) {
  const TetMesh& rest = artifacts.rest;
  const ObjectiveField& objectives = artifacts.objectives;
  const Eigen::Index n = rest.boundary_faces.rows();
  FaceAngles out{Values(n), Values(n), std::vector<char>(static_cast<std::size_t>(n)),
                 std::vector<char>(static_cast<std::size_t>(n))};
  const double largest = 90 + params.objectives.alpha_deg + kAngleTolerance;
  for (Eigen::Index f = 0; f < n; ++f) {
    const auto i = static_cast<std::size_t>(f);
    const Vec3 normal = objectives.face_normal.row(f);
    const Vec3 d = print_direction.row(rest.boundary_face_tet[i]);
    const FaceAngle angle = face_angle(normal, d);
    out.support_free[f] = angle.support_free_deg;
    out.surface_quality[f] = angle.surface_quality_deg;
    if (objectives.face_exempt[i]) continue;
    out.overhang[i] = angle.support_free_deg > largest;
    out.stairs[i] = angle.surface_quality_deg > kQualityDeg + kAngleTolerance &&
                    angle.surface_quality_deg < 90 - kQualityDeg - kAngleTolerance;
  }
  return out;
}

GougingPlaces gouging_places(const Artifacts& artifacts, const MachineProfile& machine) {
  const TetMesh& rest = artifacts.rest;
  const Values omega = concave_angles(rest, artifacts.deformation.field.print_direction);
  const double clearance = head_clearance(machine.head_cone_angle);
  std::vector<Eigen::Index> found;
  for (Eigen::Index p = 0; p < omega.size(); ++p)
    if (omega[p] < -clearance) found.push_back(p);
  const auto count = static_cast<Eigen::Index>(found.size());
  GougingPlaces out{Pairs(count, 2), Points(count, 3), Values(count), degrees(clearance)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index p = found[static_cast<std::size_t>(i)];
    out.pairs.row(i) = rest.face_pairs.row(p);
    out.places.row(i) = shared_face_centroid(rest, p).transpose();
    out.concave_deg[i] = degrees(-omega[p]);
  }
  return out;
}

Directions upright_directions(Index tets) {
  Directions directions = Directions::Zero(tets, 3);
  directions.col(2).setOnes();
  return directions;
}

}  // namespace s3
