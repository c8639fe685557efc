#include "quaternion_field/concavity_weights.h"

#include <cmath>

#include "base/units.h"

namespace s3 {

namespace {

// Twice the area times the normal of face `local` of tet t, pointing out of the tet.
Vec3 face_normal_2a(const TetMesh& mesh, Index t, Index local) {
  const auto& f = kTetFaces[static_cast<std::size_t>(local)];
  const Vec3 a = mesh.corner(t, f[0]);
  return (mesh.corner(t, f[1]) - a).cross(mesh.corner(t, f[2]) - a);
}

}  // namespace

Values concave_angles(const TetMesh& rest, const Directions& print_direction) {
  const Eigen::Index n = rest.face_pairs.rows();
  Values omega(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Index left = rest.face_pairs(i, 0);
    const Vec3 n_left = print_direction.row(left);
    const Vec3 n_right = print_direction.row(rest.face_pairs(i, 1));
    const Vec3 m = face_normal_2a(rest, left, rest.face_pair_local(i, 0));
    // atan2 keeps its accuracy for the many nearly parallel pairs, where arccos loses half of the
    // digits.
    const double angle = std::atan2(n_left.cross(n_right).norm(), n_left.dot(n_right));
    omega(i) = (n_right - n_left).dot(m) < 0 ? -angle : angle;
    if (n_left.isZero(0) || n_right.isZero(0)) omega(i) = 0;
  }
  return omega;
}

double head_clearance(double head_cone_angle) {
  return 0.5 * (kPi - head_cone_angle);
}

Index count_concave_over(const Values& omega, double angle) {
  return static_cast<Index>((omega.array() < -angle).count());
}

Index gouging_pairs(const Values& omega, double head_cone_angle) {
  return count_concave_over(omega, head_clearance(head_cone_angle));
}

Values concavity_weights(const Values& omega, double exponent) {
  return omega.unaryExpr(
      [exponent](double w) { return w < 0 ? 1.0 + std::pow(-w, exponent) : 1.0; });
}

}  // namespace s3
