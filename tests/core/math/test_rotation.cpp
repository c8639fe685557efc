#include <cmath>
#include <random>

#include <doctest/doctest.h>
#include <Eigen/SVD>

#include "base/units.h"
#include "math/rotation.h"

using namespace s3;

namespace {

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

Mat3 random_matrix(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Mat3 F;
  for (int i = 0; i < 9; ++i) F(i / 3, i % 3) = normal(random);
  return F;
}

/// The textbook answer: F = U Σ Vᵀ, R = U diag(1, 1, det UVᵀ) Vᵀ.
Mat3 closest_rotation_by_svd(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 sign = Mat3::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

void check_is_rotation(const Mat3& R) {
  CHECK((R.transpose() * R - Mat3::Identity()).norm() < 1e-12);
  CHECK(R.determinant() > 0);
}

}  // namespace

TEST_CASE("a minimal rotation takes a to b about their common perpendicular") {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = random_direction(random), b = random_direction(random);
    const Quat q = minimal_rotation(a, b);
    CHECK(std::abs(q.norm() - 1) < 1e-14);
    CHECK((q * a - b).norm() < 1e-13);
    CHECK(2 * std::acos(std::min(1.0, q.w())) ==
          doctest::Approx(std::acos(a.dot(b))).epsilon(1e-6));
    CHECK(std::abs(q.vec().dot(a)) < 1e-13);
  }
}

TEST_CASE("a minimal rotation is the identity at 0 degrees and stable around 180 degrees") {
  CHECK(minimal_rotation(Vec3::UnitX(), Vec3::UnitX()).isApprox(Quat::Identity()));
  for (const double off : {0.0, 1e-16, 1e-13, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3}) {
    const double angle = kPi - off;
    const Vec3 b(std::cos(angle), std::sin(angle), 0);
    const Quat q = minimal_rotation(Vec3::UnitX(), b);
    CAPTURE(off);
    CHECK(std::abs(q.norm() - 1) < 1e-14);
    CHECK((q * Vec3::UnitX() - b).norm() < 2e-12);
    if (off >= 1e-8) CHECK((q.vec().normalized() - Vec3::UnitZ()).norm() < 1e-7);
  }
}

TEST_CASE("the closest rotation is the one of the singular value decomposition") {
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    const Mat3 F = random_matrix(random);
    const Mat3 R = closest_rotation(F);
    check_is_rotation(R);
    CHECK((R - closest_rotation_by_svd(F)).norm() < 1e-6);
    CHECK((R.array() * F.array()).sum() >=
          (closest_rotation_by_svd(F).array() * F.array()).sum() - 1e-12);
  }
}

TEST_CASE(
    "the closest rotation is a rotation for flat, reflecting, thin, huge, tiny and zero matrices") {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  CHECK((closest_rotation(turn) - turn).norm() < 1e-14);
  CHECK((closest_rotation(1e-30 * turn) - turn).norm() < 1e-13);
  CHECK((closest_rotation(1e30 * turn) - turn).norm() < 1e-13);
  for (const double thin : {1e-3, 1e-5, 1e-7, 1e-12, 0.0, -1e-12, -1e-6, -0.5}) {
    CAPTURE(thin);
    const Mat3 R = closest_rotation(turn * Vec3(2, 1, thin).asDiagonal());
    check_is_rotation(R);
    CHECK((R - turn).norm() < 1e-9);
  }
  check_is_rotation(closest_rotation(Mat3::Zero()));
  check_is_rotation(closest_rotation(-Mat3::Identity()));
  check_is_rotation(closest_rotation(Vec3(1, 2, 3) * Vec3(3, 1, 2).transpose()));
}

TEST_CASE("alignment and blending treat q and -q as one rotation") {
  const Quat a(Eigen::AngleAxisd(0.2, Vec3::UnitZ()));
  const Quat b(Eigen::AngleAxisd(0.6, Vec3::UnitZ()));
  const Quat minus_b(-b.w(), -b.x(), -b.y(), -b.z());
  CHECK(aligned(minus_b, a).coeffs() == b.coeffs());
  CHECK(aligned(b, a).coeffs() == b.coeffs());
  CHECK((blend(a, minus_b, 0.5).coeffs() - blend(a, b, 0.5).coeffs()).norm() == 0);
  CHECK(blend(a, minus_b, 0.5).angularDistance(Quat(Eigen::AngleAxisd(0.4, Vec3::UnitZ()))) < 1e-7);
}
