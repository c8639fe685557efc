#include "tetrahedralize/tetrahedralize.h"

#include <cmath>
#include <utility>
#include <vector>

#include "mesh/refine_surface.h"
#include "tetrahedralize/isosurface_stuffing.h"
#include "tetrahedralize/tetgen_backend.h"

namespace s3 {

namespace {

[[noreturn]] void throw_empty() {
  throw Error(ErrorKind::slicing, Stage::tetrahedralize, "tetrahedralize.empty",
              "The surface encloses no volume",
              "Check that the surface is closed and that its triangles face outward");
}

// Splits coarse triangles first. Where the split triangles force more tets than wanted, as on thin
// parts, larger ones are tried.
TetMesh fill_refined_with_tetgen(const TriMesh& surface, int target_tets, Context& ctx) {
  constexpr int kMaxTries = 3;
  constexpr double kCountTolerance = 0.15;
  if (!(enclosed_volume(surface) > 0)) throw_empty();
  double edge = target_edge_for(surface, target_tets);
  const std::vector<Warning> warnings = ctx.warnings;
  for (int i = 1;; ++i) {
    const TriMesh refined = refine_surface(surface, edge);
    TetMesh mesh = fill_with_tetgen(refined, target_tets, ctx);
    const double excess = mesh.tet_count() / static_cast<double>(target_tets);
    const bool was_split = refined.triangles.rows() > surface.triangles.rows();
    if (excess <= 1 + kCountTolerance || !was_split || i == kMaxTries) return mesh;
    ctx.warnings = warnings;  // those of the mesh that is not used
    edge *= std::sqrt(excess);
  }
}

}  // namespace

Tetrahedralization tetrahedralize(const TriMesh& surface, const TetrahedralizeParams& params,
                                  Context& ctx, const std::string& defect) {
  ctx.checkpoint();
  if (surface.triangles.rows() == 0) throw_empty();
  if (params.backend == "stuffing")
    return {fill_by_stuffing(surface, params.target_tets, ctx), "stuffing", {}};
  if (params.backend == "tetgen") {
    if (!defect.empty())
      throw Error(ErrorKind::input, Stage::tetrahedralize, "tetrahedralize.failed",
                  "TetGen cannot fill this surface: " + defect,
                  "Repair the surface, or set mesh.backend to auto");
    return {fill_refined_with_tetgen(surface, params.target_tets, ctx), "tetgen", {}};
  }

  std::string reason = defect;
  if (reason.empty() && !has_tetgen()) reason = "This build was made without TetGen";
  if (reason.empty()) {
    try {
      return {fill_refined_with_tetgen(surface, params.target_tets, ctx), "tetgen", {}};
    } catch (const Error& error) {
      if (error.code == "tetrahedralize.empty") throw;
      reason = error.what();
    }
  }
  ctx.warn(
      "tetrahedralize.stuffed",
      "The model was filled by isosurface stuffing, which approximates its surface: " + reason);
  return {fill_by_stuffing(surface, params.target_tets, ctx), "stuffing", reason};
}

}  // namespace s3
