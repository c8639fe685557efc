#include "quaternion_field/rotations_from_deformation.h"

#include <cmath>
#include <vector>

#include "math/rotation.h"

namespace s3 {

Vec3 print_direction_of(const Eigen::Ref<const Eigen::Matrix<double, 1, 4>>& q) {
  // The third row of R(q), which is R⁻¹ z.
  const double x = q(0), y = q(1), z = q(2), w = q(3);
  return {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
}

Quats identity_rotations(Index tet_count) {
  return Eigen::RowVector4d(0, 0, 0, 1).replicate(tet_count, 1);
}

Quats rotations_from_deformation(const TetMesh& rest, const Points& deformed, const Quats& previous,
                                 Context& ctx) {
  Quats rotation(rest.tet_count(), 4);
  const auto tets = static_cast<std::size_t>(rest.tet_count());
  parallel_for(ctx.pool, tets, 4096, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t) {
      Eigen::Matrix<double, 3, 4> corners;
      for (int i = 0; i < 4; ++i) corners.col(i) = deformed.row(rest.tets(t, i));
      // F = Σ x_i ⊗ ∇φ_i.
      const Mat3 gradient = corners * hat_gradients(rest, t).transpose();
      const Quat q(closest_rotation(gradient));
      rotation.row(t) = q.coeffs();
      if (rotation.row(t).dot(previous.row(t)) < 0) rotation.row(t) *= -1;
    }
  });
  return rotation;
}

void align_signs(const TetMesh& rest, Quats& rotation) {
  std::vector<char> seen(static_cast<std::size_t>(rest.tet_count()), 0);
  std::vector<Index> queue;
  queue.reserve(seen.size());
  for (Index seed = 0; seed < rest.tet_count(); ++seed) {
    if (seen[seed]) continue;
    seen[seed] = 1;
    queue.assign(1, seed);
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const Index t = queue[head];
      for (int f = 0; f < 4; ++f) {
        const Index other = rest.neighbors(t, f);
        if (other < 0 || seen[other]) continue;
        seen[other] = 1;
        if (rotation.row(other).dot(rotation.row(t)) < 0) rotation.row(other) *= -1;
        queue.push_back(other);
      }
    }
  }
}

Index incompatible_pairs(const TetMesh& rest, const Quats& rotation, double threshold) {
  // For unit quaternions ‖a ∓ b‖² = 2 ∓ 2 a·b.
  const double least_dot = 1 - 0.5 * threshold * threshold;
  Index count = 0;
  for (Eigen::Index p = 0; p < rest.face_pairs.rows(); ++p) {
    const double dot = rotation.row(rest.face_pairs(p, 0)).dot(rotation.row(rest.face_pairs(p, 1)));
    count += std::abs(dot) < least_dot;
  }
  return count;
}

}  // namespace s3
