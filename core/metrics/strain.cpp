#include "metrics/strain.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "fea/linear_elasticity.h"
#include "fea/loading.h"
#include "fea/stress.h"
#include "mesh/aabb_tree.h"

namespace s3 {
namespace {

constexpr std::size_t kGrain = 512;  // tets
constexpr double kPercentile = 0.999;
// A normal closer than this to the tangent says nothing about the layer.
constexpr double kParallel = 1e-6;

/// The extruded segments as triangles without area, each ending at a waypoint.
struct Beads {
  Triangles segment;        // #S×3: waypoints before, at and at the end
  std::vector<Index> last;  // #S: the waypoint at the end
};

Beads beads_of(const Waypoints& waypoints) {
  Beads beads;
  for (Index w = 1; w < waypoints.size(); ++w)
    if (waypoints.travel[static_cast<std::size_t>(w)] == 0 &&
        waypoints.position.row(w) != waypoints.position.row(w - 1))
      beads.last.push_back(w);
  beads.segment.resize(static_cast<Eigen::Index>(beads.last.size()), 3);
  for (std::size_t s = 0; s < beads.last.size(); ++s)
    beads.segment.row(static_cast<Eigen::Index>(s)) << beads.last[s] - 1, beads.last[s],
        beads.last[s];
  return beads;
}

Mat3 frame_of(const Vec3& tangent, const Vec3& normal) {
  Vec3 across_layer = normal - normal.dot(tangent) * tangent;
  if (across_layer.norm() < kParallel) across_layer = tangent.unitOrthogonal();
  Mat3 frame;
  frame.col(0) = tangent;
  frame.col(2) = across_layer.normalized();
  frame.col(1) = frame.col(2).cross(tangent);
  return frame;
}

/// Twice the strain tensor's shear is stored; principal_stresses() wants the tensor.
double largest_principal_strain(Vector6 strain) {
  strain.tail<3>() *= 0.5;
  return principal_stresses(strain).value[2];
}

}  // namespace

std::vector<Mat3> bead_frames(const TetMesh& rest, const Waypoints& waypoints, Context& ctx) {
  const Beads beads = beads_of(waypoints);
  if (beads.last.empty())
    throw Error(ErrorKind::slicing, Stage::metrics, "metrics.no_beads",
                "There is no bead to take the material's directions from.",
                "Check that the layers have toolpaths.");
  const AabbTree tree(waypoints.position, beads.segment);
  std::vector<Mat3> frames(static_cast<std::size_t>(rest.tet_count()));
  parallel_for(ctx.pool, frames.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    Vec3 from = rest.centroid(static_cast<Index>(begin));
    double bound = std::numeric_limits<double>::infinity();
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3 centroid = rest.centroid(static_cast<Index>(t));
      // Tets follow a Morton curve: the last answer bounds the next.
      bound = 1.0001 * (bound + (centroid - from).norm()) + 1e-9;
      const Closest nearest = tree.closest(centroid, bound);
      bound = nearest.distance;
      from = centroid;
      const Index last = beads.last[static_cast<std::size_t>(nearest.triangle)];
      const double share = std::clamp(1 - nearest.barycentric[0], 0.0, 1.0);  // of the way
      const Vec3 a = waypoints.position.row(last - 1), b = waypoints.position.row(last);
      const Vec3 normal = (1 - share) * waypoints.normal.row(last - 1).transpose() +
                          share * waypoints.normal.row(last).transpose();
      frames[t] = frame_of((b - a).normalized(), normal);
    }
  });
  return frames;
}

Values printed_strain(const TetMesh& rest, const std::vector<Mat3>& frames, const LoadCases& file,
                      Context& ctx) {
  const ElasticBody body{orthotropic_stiffness(file.material.printed), frames};
  const std::vector<Loading> loadings = apply_load_cases(rest, file, ctx);
  const std::vector<Points> displacements = solve_elasticity(rest, body, loadings, {}, ctx);
  Values worst = Values::Zero(rest.tet_count());
  for (const Points& displacement : displacements) {
    const Tensors strain = strains(rest, displacement, ctx);
    parallel_for(ctx.pool, static_cast<std::size_t>(rest.tet_count()), kGrain,
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t i = begin; i < end; ++i) {
                     const auto t = static_cast<Eigen::Index>(i);
                     worst[t] =
                         std::max(worst[t], largest_principal_strain(strain.row(t).transpose()));
                   }
                 });
  }
  return worst;
}

Values printed_strain(const TetMesh& rest, const Waypoints& waypoints, const LoadCases& file,
                      Context& ctx) {
  return printed_strain(rest, bead_frames(rest, waypoints, ctx), file, ctx);
}

StrainFigures strain_figures(const Values& strain, const Values& volume) {
  std::vector<Index> order(static_cast<std::size_t>(strain.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    return strain[a] != strain[b] ? strain[a] < strain[b] : a < b;
  });
  const double total = volume.sum();
  StrainFigures figures{strain[order.back()], strain[order.back()], strain.dot(volume) / total};
  double below = 0;
  for (const Index t : order) {
    below += volume[t];
    if (below < kPercentile * total) continue;
    figures.p999 = strain[t];
    break;
  }
  return figures;
}

}  // namespace s3
