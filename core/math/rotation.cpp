// Closest rotation: scaled Newton iteration of the polar decomposition (Higham 1986) where F is
// well behaved, and Davenport's quaternion eigenproblem, which knows rotations only, where it is
// not.
#include "math/rotation.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace s3 {
namespace {

// a + b of opposite unit vectors is rounding noise below this.
constexpr double kOpposite = 1e-12;
// Newton's iteration needs an inverse: below this det F / ‖F‖³ it would take too many steps.
constexpr double kWellConditioned = 1e-6;
// Squared change after which one more (quadratically convergent) step is exact to rounding.
constexpr double kLastStep = 1e-16;

Vec3 any_perpendicular(const Vec3& a) {
  int smallest = 0;
  a.cwiseAbs().minCoeff(&smallest);
  return a.cross(Vec3::Unit(smallest)).normalized();
}

Mat3 cofactors(const Mat3& F) {
  Mat3 C;
  C.col(0) = F.col(1).cross(F.col(2));
  C.col(1) = F.col(2).cross(F.col(0));
  C.col(2) = F.col(0).cross(F.col(1));
  return C;
}

/// tr(R(q)ᵀ F) = qᵀ K q with q = (x, y, z, w): the largest eigenvector of K is the answer, for
/// every F.
Mat3 closest_rotation_by_eigenvector(const Mat3& F) {
  const double size = F.norm();
  if (!(size > 0)) return Mat3::Identity();
  Eigen::Matrix4d K;
  K << F(0, 0) - F(1, 1) - F(2, 2), F(0, 1) + F(1, 0), F(0, 2) + F(2, 0), F(2, 1) - F(1, 2),
      F(0, 1) + F(1, 0), F(1, 1) - F(0, 0) - F(2, 2), F(1, 2) + F(2, 1), F(0, 2) - F(2, 0),
      F(0, 2) + F(2, 0), F(1, 2) + F(2, 1), F(2, 2) - F(0, 0) - F(1, 1), F(1, 0) - F(0, 1),
      F(2, 1) - F(1, 2), F(0, 2) - F(2, 0), F(1, 0) - F(0, 1), F.trace();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(K / size);
  const Eigen::Vector4d q = eigen.eigenvectors().col(3);
  return Quat(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
}

}  // namespace

Quat minimal_rotation(const Vec3& a, const Vec3& b) {
  // Axis a×b and w = 1 + a·b, written with a + b so that neither cancels near 180°.
  const Vec3 sum = a + b;
  const double w = 0.5 * sum.squaredNorm();
  if (sum.norm() < kOpposite) {
    const Vec3 axis = any_perpendicular(a);
    return {0, axis.x(), axis.y(), axis.z()};
  }
  const Vec3 axis = a.cross(sum);
  return Quat(w, axis.x(), axis.y(), axis.z()).normalized();
}

Mat3 closest_rotation(const Mat3& F) {
  const double size = F.norm();
  if (!(F.determinant() > kWellConditioned * size * size * size))
    return closest_rotation_by_eigenvector(F);
  Mat3 X = F / size;
  for (int i = 0; i < 30; ++i) {
    const Mat3 C = cofactors(X);
    const Mat3 inverse_transposed = C / X.col(0).dot(C.col(0));
    // γ brings the singular values together; near the end it is 1 and convergence quadratic.
    const double gamma = std::sqrt(inverse_transposed.norm() / X.norm());
    const Mat3 next = 0.5 * (gamma * X + inverse_transposed / gamma);
    const double change = (next - X).squaredNorm();
    X = next;
    if (change < kLastStep) break;
  }
  const Mat3 C = cofactors(X);
  return 0.5 * (X + C / X.col(0).dot(C.col(0)));
}

Quat aligned(const Quat& q, const Quat& reference) {
  return q.dot(reference) < 0 ? Quat(-q.w(), -q.x(), -q.y(), -q.z()) : q;
}

Quat blend(const Quat& a, const Quat& b, double s) {
  const Quat near = aligned(b, a);
  return Quat((1 - s) * a.coeffs() + s * near.coeffs()).normalized();
}

}  // namespace s3
