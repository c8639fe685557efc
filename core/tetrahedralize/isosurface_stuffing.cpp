// F. Labelle, J. R. Shewchuk, "Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral
// Angles", ACM TOG 26(3), 2007, on the winding number of A. Jacobson, L. Kavan, O. Sorkine-Hornung,
// "Robust Inside-Outside Segmentation using Generalized Winding Numbers", ACM TOG 32(4), 2013.
#include "tetrahedralize/isosurface_stuffing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "mesh/reorder.h"
#include "tetrahedralize/bcc_lattice.h"
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
constexpr int kMaxRuns = 6;
// A volume that is off by more than this is worth a warning.
constexpr double kVolumeSlack = 0.02;

struct Filling {
  BccLattice lattice;
  TetMesh mesh;
  double solid_volume = 0;  // mm³, by the share of lattice vertices inside
};

Filling fill_lattice(const SurfaceSolid& solid, double size, Context& ctx) {
  Filling filling;
  filling.lattice = lattice_around(solid.box.min, solid.box.max, size);
  const std::vector<char> inside = inside_flags(filling.lattice, solid, ctx);
  const auto vertices_inside = static_cast<double>(std::count(inside.begin(), inside.end(), 1));
  filling.solid_volume = vertices_inside * size * size * size / 2;
  filling.mesh = stuff_lattice(filling.lattice, inside,
                               lattice_cuts(filling.lattice, inside, solid, ctx), ctx);
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
  const double smallest = smallest_lattice_size(solid.box.min, solid.box.max);
  const Vec3 extent = solid.box.max - solid.box.min;
  double size = std::cbrt(kTetsPerCube * volume / (kFirstShare * target));
  size = std::clamp(size, smallest, std::max(smallest, extent.maxCoeff() / 4));
  Filling best;
  double best_miss = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kMaxRuns; ++run) {
    Filling filling = fill_lattice(solid, size, ctx);
    ctx.progress(Stage::tetrahedralize, 0.1 * (run + 1));
    const double count = filling.mesh.tet_count();
    if (count == 0) {
      if (size <= smallest) break;
      size = std::max(smallest, size / 2);
      continue;
    }
    const double miss = std::abs(std::log(count / target));
    const double next = std::max(smallest, size_for(target, filling));
    if (miss < best_miss) {
      best_miss = miss;
      best = std::move(filling);
    }
    if (std::abs(count - target) <= kCountTolerance * target || next == size) break;
    size = next;
  }
  if (best.mesh.tet_count() == 0) throw_empty();
  return best;
}

void warn_about_count(double count, int target, Context& ctx) {
  if (std::abs(count - target) > kAllowedMiss * target)
    ctx.warn(count > target ? "tetrahedralize.more_tets" : "tetrahedralize.fewer_tets",
             "The mesh has " + std::to_string(static_cast<long>(count)) + " tets instead of " +
                 std::to_string(target));
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
  Filling filling =
      fill_to_target(solid, plausible ? enclosed : 0.25 * box_volume, target_tets, ctx);
  fit_boundary(filling.mesh, solid, feature_curves(surface), filling.lattice.size, ctx);
  ctx.progress(Stage::tetrahedralize, 0.9);
  warn_about_count(filling.mesh.tet_count(), target_tets, ctx);
  warn_about_volume(tet_volumes(filling.mesh).sum(), filling.solid_volume, filling.lattice.size,
                    ctx);
  TetMesh mesh = reorder_along_morton(filling.mesh);
  ctx.progress(Stage::tetrahedralize, 1.0);
  return mesh;
}

}  // namespace s3
