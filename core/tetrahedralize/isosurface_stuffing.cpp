// F. Labelle, J. R. Shewchuk, "Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral
// Angles", ACM TOG 26(3), 2007, on the winding number of A. Jacobson, L. Kavan, O. Sorkine-Hornung,
// "Robust Inside-Outside Segmentation using Generalized Winding Numbers", ACM TOG 32(4), 2013.
#include "tetrahedralize/isosurface_stuffing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "mesh/reorder.h"
#include "mesh/weld.h"
#include "tetrahedralize/bcc_lattice.h"
#include "tetrahedralize/coarsen_interior.h"
#include "tetrahedralize/feature_curves.h"
#include "tetrahedralize/fit_boundary.h"
#include "tetrahedralize/lattice_cuts.h"
#include "tetrahedralize/stencils.h"

namespace s3 {

namespace {

constexpr double kTetsPerCube = 12;
// The first lattice is coarse: it only tells how the count depends on the size.
constexpr double kFirstShare = 0.2;
constexpr double kCountTolerance = 0.08;
constexpr double kAllowedMiss = 0.15;
constexpr int kMaxRuns = 8;
// What a lattice four times as fine does not hit either is nothing.
constexpr int kMaxEmptyRuns = 2;
// The lattice is finer than the target asks for by this factor of tets; coarser tets inside make up
// for it.
constexpr double kFiner = 2;
// A volume that is off by more than this is worth a warning.
constexpr double kVolumeSlack = 0.03;

struct Filling {
  BccLattice lattice;
  TetMesh mesh;
  // By counts of lattice vertices, mm³: the volume where the winding number is over 1/2, and the
  // integral of what the winding number is beyond that (overlaps, shells inside out).
  double solid_volume = 0, excess = 0;
};

Filling fill_lattice(const SurfaceSolid& solid, double size, Context& ctx) {
  Filling filling;
  filling.lattice = lattice_around(solid.box.min, solid.box.max, size);
  const std::vector<signed char> winding = winding_at_vertices(filling.lattice, solid, ctx);
  const double share = size * size * size / 2;
  for (const signed char w : winding) {
    filling.solid_volume += w > 0 ? share : 0;
    filling.excess += share * (w > 0 ? w - 1 : w);
  }
  filling.mesh = stuff_lattice(filling.lattice, winding,
                               lattice_cuts(filling.lattice, winding, solid, ctx), ctx);
  return filling;
}

// The size for a wanted count from what one size gave: count = a/size³ + b/size², where a is known
// from the volume.
double size_for(double target, const Filling& known) {
  const double size = known.lattice.size,
               a = kTetsPerCube * std::max(known.solid_volume, tet_volumes(known.mesh).sum()),
               b = std::max(0.0, (known.mesh.tet_count() - a / (size * size * size)) * size * size);
  double small = size / 64, large = size * 64;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (small + large);
    (a / (middle * middle * middle) + b / (middle * middle) > target ? small : large) = middle;
  }
  return 0.5 * (small + large);
}

// Twenty bits of a size: the last bits of cube roots and long sums differ between platforms.
double rounded(double size) {
  constexpr double kSteps = 1 << 20;
  int exponent = 0;
  const double mantissa = std::frexp(size, &exponent);
  return std::ldexp(std::round(mantissa * kSteps) / kSteps, exponent);
}

[[noreturn]] void throw_empty() {
  throw Error(ErrorKind::slicing, Stage::tetrahedralize, "tetrahedralize.empty",
              "No point has triangles of the surface around it",
              "Check that the surface is closed but for small holes, that its triangles face "
              "outward, and that its walls are not thinner than a tet");
}

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", 100 * share);
  return text;
}

// The lattice whose filling has the wanted count.
Filling fill_to_target(const SurfaceSolid& solid, double volume, double target, Context& ctx) {
  const double smallest = rounded(smallest_lattice_size(solid.box.min, solid.box.max));
  const Vec3 extent = solid.box.max - solid.box.min;
  double size = std::cbrt(kTetsPerCube * volume / (kFirstShare * target));
  size = rounded(std::clamp(size, smallest, std::max(smallest, extent.maxCoeff() / 4)));
  // Sizes known to give too many and too few tets: thin walls make the count jump between them.
  double too_small = smallest, too_large = std::numeric_limits<double>::infinity();
  Filling best;
  double best_miss = std::numeric_limits<double>::infinity();
  int empty_runs = 0;
  for (int run = 0; run < kMaxRuns; ++run) {
    Filling filling = fill_lattice(solid, size, ctx);
    ctx.progress(Stage::tetrahedralize, 0.8 * (run + 1) / kMaxRuns);
    const double count = filling.mesh.tet_count();
    (count > target ? too_small : too_large) = size;
    double next = count > 0 ? size_for(target, filling) : size / 2;
    if (next <= too_small || next >= too_large)
      next = std::sqrt(too_small * std::min(too_large, 2 * size));
    const double miss = count > 0 ? std::abs(std::log(count / target)) : best_miss;
    if (miss < best_miss) {
      best_miss = miss;
      best = std::move(filling);
    }
    if (std::abs(count - target) <= kCountTolerance * target || size == smallest) break;
    if (count == 0 && ++empty_runs > kMaxEmptyRuns) break;
    size = rounded(std::max(smallest, next));
  }
  if (best.mesh.tet_count() == 0) throw_empty();
  return best;
}

// As fine a boundary as the target allows. Where too much of the solid is near its boundary, the
// lattice is made coarser.
Filling fill_graded(const SurfaceSolid& solid, double volume, int target, Context& ctx) {
  constexpr int kMaxTries = 3;
  double finer = kFiner;
  for (int i = 1;; ++i) {
    Filling filling = fill_to_target(solid, volume, finer * target, ctx);
    if (finer > 1) coarsen_interior(filling.mesh, target, ctx);
    const double excess = filling.mesh.tet_count() / static_cast<double>(target);
    if (excess <= 1 + kCountTolerance || finer <= 1) return filling;
    finer = i == kMaxTries ? 1 : std::max(1.0, finer / excess);
  }
}

void warn_about_count(double count, int target, Context& ctx) {
  if (std::abs(count - target) > kAllowedMiss * target)
    ctx.warn(count > target ? "tetrahedralize.more_tets" : "tetrahedralize.fewer_tets",
             "The mesh has " + std::to_string(static_cast<long>(count)) + " tets instead of " +
                 std::to_string(target));
}

// Every edge is run along as often in one direction as in the other.
bool is_closed(const TriMesh& surface) {
  Welder welder(static_cast<std::size_t>(surface.vertices.rows()));
  std::vector<Index> vertex(static_cast<std::size_t>(surface.vertices.rows()));
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    vertex[static_cast<std::size_t>(v)] = welder.add(surface.vertices.row(v));
  std::vector<std::tuple<Index, Index, int>> edges;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i) {
      const Index a = vertex[static_cast<std::size_t>(surface.triangles(f, i))],
                  b = vertex[static_cast<std::size_t>(surface.triangles(f, (i + 1) % 3))];
      edges.emplace_back(std::min(a, b), std::max(a, b), a < b ? 1 : a > b ? -1 : 0);
    }
  std::sort(edges.begin(), edges.end());
  int balance = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto& [a, b, direction] = edges[i];
    balance += direction;
    const bool last =
        i + 1 == edges.size() || std::get<0>(edges[i + 1]) != a || std::get<1>(edges[i + 1]) != b;
    if (last && balance != 0) return false;
  }
  return true;
}

// The volume where the winding number is over 1/2, mm³. A closed surface encloses the integral of
// the winding number, so that only overlaps are left to counting.
double solid_volume(const TriMesh& surface, const Filling& filling) {
  return is_closed(surface) ? enclosed_volume(surface) - filling.excess : filling.solid_volume;
}

void warn_about_volume(double volume, double solid_volume, double size, Context& ctx) {
  if (std::abs(volume - solid_volume) <= kVolumeSlack * solid_volume) return;
  char edge[32];
  std::snprintf(edge, sizeof edge, "%.2f mm", size);
  ctx.warn("tetrahedralize.unresolved",
           "The tet mesh has " + percent(volume / solid_volume) +
               " of the model's volume: walls or gaps thinner than about " + edge +
               " are lost; more tets (mesh.target_tets) resolve them");
}

}  // namespace

TetMesh fill_by_stuffing(const TriMesh& surface, int target_tets, Context& ctx) {
  ctx.progress(Stage::tetrahedralize, 0.0);
  const SurfaceSolid solid(surface);
  const Vec3 extent = solid.box.max - solid.box.min;
  if (!(extent.minCoeff() > 0)) throw_empty();
  const double enclosed = enclosed_volume(surface), box_volume = extent.prod();
  const bool plausible = enclosed > 1e-4 * box_volume && enclosed <= box_volume;
  Filling filling = fill_graded(solid, plausible ? enclosed : 0.25 * box_volume, target_tets, ctx);
  fit_boundary(filling.mesh, solid, feature_curves(surface), filling.lattice.size, ctx);
  ctx.progress(Stage::tetrahedralize, 0.9);
  warn_about_count(filling.mesh.tet_count(), target_tets, ctx);
  warn_about_volume(tet_volumes(filling.mesh).sum(), solid_volume(surface, filling),
                    filling.lattice.size, ctx);
  TetMesh mesh = reorder_along_morton(filling.mesh);
  ctx.progress(Stage::tetrahedralize, 1.0);
  return mesh;
}

}  // namespace s3
