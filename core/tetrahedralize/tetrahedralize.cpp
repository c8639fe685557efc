#include "tetrahedralize/tetrahedralize.h"

#include <utility>

#include "tetrahedralize/fill_solid.h"
#include "tetrahedralize/isosurface_stuffing.h"
#include "tetrahedralize/tetgen_backend.h"

namespace s3 {

namespace {

[[noreturn]] void throw_empty() {
  throw Error(ErrorKind::slicing, Stage::tetrahedralize, "tetrahedralize.empty",
              "The surface encloses no volume",
              "Check that the surface is closed and that its triangles face outward");
}

// @throws Error "tetrahedralize.empty"
Tetrahedralization fill_by_tetgen(const TriMesh& surface, int target_tets, Context& ctx) {
  if (!(enclosed_volume(surface) > 0)) throw_empty();
  SolidFilling filling = fill_solid(surface, target_tets, ctx);
  return {std::move(filling.mesh), "tetgen", {}, filling.simplified};
}

}  // namespace

Tetrahedralization tetrahedralize(const TriMesh& surface, const TetrahedralizeParams& params,
                                  Context& ctx, const std::string& defect) {
  ctx.checkpoint();
  if (surface.triangles.rows() == 0) throw_empty();
  if (params.backend == "stuffing")
    return {fill_by_stuffing(surface, params.target_tets, ctx), "stuffing", {}, true};
  if (params.backend == "tetgen") {
    if (!defect.empty())
      throw Error(ErrorKind::input, Stage::tetrahedralize, "tetrahedralize.failed",
                  "TetGen cannot fill this surface: " + defect,
                  "Repair the surface, or set mesh.backend to auto");
    return fill_by_tetgen(surface, params.target_tets, ctx);
  }

  std::string reason = defect;
  if (reason.empty() && !has_tetgen()) reason = "This build was made without TetGen";
  if (reason.empty()) {
    try {
      return fill_by_tetgen(surface, params.target_tets, ctx);
    } catch (const Error& error) {
      if (error.code == "tetrahedralize.empty") throw;
      reason = error.what();
    }
  }
  ctx.warn(
      "tetrahedralize.stuffed",
      "The model was filled by isosurface stuffing, which approximates its surface: " + reason);
  return {fill_by_stuffing(surface, params.target_tets, ctx), "stuffing", reason, true};
}

}  // namespace s3
