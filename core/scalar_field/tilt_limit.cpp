#include "scalar_field/tilt_limit.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace s3 {

namespace {

// The repair aims at a slightly narrower cone, so that it ends inside the one that is asked for.
constexpr double kRepairMargin = 0.02;  // rad
constexpr int kRepairIterations = 40;
// Weight of a tet that has been outside, against 1 for all others to stay as they are.
constexpr double kRepairWeight = 30;
// Rounding must not turn "exactly on the cone" into "outside".
constexpr double kBlendMargin = 1e-6;

double horizontal(const Vec3& g) {
  return std::hypot(g.x(), g.y());
}

bool tilted(const Vec3& g, double tan_tilt) {
  return !(g.z() > 0 && horizontal(g) <= tan_tilt * g.z());
}

// The closest point of the cone |g_xy| ≤ tan·g_z with at least the length `least`.
Vec3 into_cone(const Vec3& g, double max_tilt, double least) {
  const double across = horizontal(g);
  const Vec3 side = across > 0 ? Vec3(g.x() / across, g.y() / across, 0) : Vec3(Vec3::UnitX());
  const Vec3 border = std::sin(max_tilt) * side + std::cos(max_tilt) * Vec3::UnitZ();
  return std::max(least, border.dot(g)) * border;
}

// One matrix for each repair: everything stays, tets that have been outside weigh more.
Values repair_locally(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                      const Values& start, double max_tilt, Context& ctx) {
  const double tan_tilt = std::tan(max_tilt);
  Points wanted, gradient;
  operators.gradients(start, wanted, ctx);
  const double least = 0.1 * wanted.rowwise().norm().mean();
  std::vector<char> weighty(static_cast<std::size_t>(rest.tet_count()), 0);
  Points dual = Points::Zero(rest.tet_count(), 3), force(rest.tet_count(), 3);
  Values value = start, weight(rest.tet_count()), vertex_force;
  Block right(anchors.free_count, 1), change(anchors.free_count, 1);
  const auto solver = make_solver({.tolerance = 1e-2});
  for (int iteration = 0; iteration < kRepairIterations; ++iteration) {
    ctx.checkpoint();
    operators.gradients(value, gradient, ctx);
    Index outside = 0, joined = 0;
    for (Index t = 0; t < rest.tet_count(); ++t) {
      if (!tilted(gradient.row(t), tan_tilt)) continue;
      ++outside;
      joined += weighty[t] == 0;
      weighty[t] = 1;
    }
    if (outside == 0) break;
    if (joined > 0) {
      for (Index t = 0; t < rest.tet_count(); ++t)
        weight(t) = operators.volume(t) * (weighty[t] ? kRepairWeight : 1);
      solver->factor(operators.energy(weight, {}, anchors.free_index, ctx), ctx);
    }
    for (Index t = 0; t < rest.tet_count(); ++t) {
      Vec3 aim = wanted.row(t);
      if (weighty[t]) {
        const Vec3 x = gradient.row(t) + dual.row(t);
        const double inner = std::max(0.5 * max_tilt, max_tilt - kRepairMargin);
        const Vec3 z = tilted(x, std::tan(inner)) ? into_cone(x, inner, least) : x;
        dual.row(t) = x - z;
        aim = z - dual.row(t).transpose();
      }
      force.row(t) = weight(t) * (aim - gradient.row(t).transpose());
    }
    operators.adjoint(force, vertex_force, ctx);
    anchors.gather_free(vertex_force, right);
    change.setZero();
    solver->solve(right, change, ctx);
    anchors.add_free(change, value);
  }
  return value;
}

// (1 − s)·∇G + s·z lies in the cone from s = (|g_xy| − tan·g_z) / (|g_xy| − tan·g_z + tan) on.
Values blend_with_planar(const TetMesh& rest, const FieldOperators& operators,
                         const Anchors& anchors, const Values& value, double max_tilt) {
  const double tan_tilt = std::tan(max_tilt);
  double share = 0;
  for (Index t = 0; t < rest.tet_count(); ++t) {
    const Vec3 g = operators.gradient(value, t);
    if (!tilted(g, tan_tilt)) continue;
    const double excess = std::max(0.0, horizontal(g) - tan_tilt * g.z());
    share = std::max(share, excess / (excess + tan_tilt) + kBlendMargin);
  }
  share = std::min(share, 1.0);
  return (1 - share) * value + share * anchors.planar;
}

}  // namespace

Index count_tilted(const TetMesh& rest, const FieldOperators& operators, const Values& value,
                   double max_tilt) {
  Index count = 0;
  for (Index t = 0; t < rest.tet_count(); ++t)
    count += tilted(operators.gradient(value, t), std::tan(max_tilt));
  return count;
}

Values limit_tilt(const TetMesh& rest, const FieldOperators& operators, const Anchors& anchors,
                  Values value, double max_tilt, Context& ctx) {
  if (count_tilted(rest, operators, value, max_tilt) == 0) return value;
  if (anchors.free_count > 0)
    value = repair_locally(rest, operators, anchors, value, max_tilt, ctx);
  return blend_with_planar(rest, operators, anchors, value, max_tilt);
}

}  // namespace s3
