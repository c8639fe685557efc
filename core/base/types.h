// The shapes that flow through the pipeline. Units everywhere: mm, N, MPa, s, rad; z up;
// right-handed.
#pragma once
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace s3 {

using Index = std::int32_t;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

/// #V×3, mm, row-major: memory is xyzxyz…
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// #×3 unit vectors.
using Directions = Points;
/// #F×3 vertex indices, counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<Index, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// #T×4 vertex indices, positive volume: det(v1-v0, v2-v0, v3-v0) > 0.
using Tets = Eigen::Matrix<Index, Eigen::Dynamic, 4, Eigen::RowMajor>;
/// #T×4 unit quaternions, x y z w as Eigen and three.js store them.
using Quats = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;
/// One scalar per row of something.
using Values = Eigen::VectorXd;
/// #×2 index pairs.
using Pairs = Eigen::Matrix<Index, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// d_p of the paper: the build direction of the deformed shape.
inline Vec3 build_direction() {
  return Vec3::UnitZ();
}

}  // namespace s3
