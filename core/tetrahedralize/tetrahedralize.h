// From a surface to a tet mesh of a wanted size (Sec. 2): the only door to the meshers.
#pragma once
#include <string>

#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "mesh/tri_mesh.h"
#include "params/param_info.h"

namespace s3 {

struct TetrahedralizeParams {
  int target_tets = 100000;
  std::string backend = "auto";
};

template <class Visitor>
void describe(Visitor& v, TetrahedralizeParams& p) {
  v(p.target_tets,
    ParamInfo{.key = "mesh.target_tets",
              .label = "Tets",
              .unit = "",
              .doc = "Wanted number of tets of the volume mesh, 100 or more; 0 for two "
                     "across the thinnest wall, within 30000 and 1000000. Ignored "
                     "for volume meshes, which are used as they are.",
              .min = 0,
              .max = 5e6,
              .stage = Stage::tetrahedralize});
  v(p.backend, ParamInfo{.key = "mesh.backend",
                         .label = "Mesher",
                         .unit = "",
                         .doc = "tetgen: keeps the surface, which must be valid; stuffing: "
                                "takes any triangles and approximates them; auto: tetgen where it "
                                "works, else stuffing.",
                         .choices = {"auto", "tetgen", "stuffing"},
                         .stage = Stage::tetrahedralize});
}

struct Tetrahedralization {
  TetMesh mesh;               // vertices and tets along a Morton curve, with topology
  std::string backend;        // "tetgen" or "stuffing": what made it
  std::string fallback;       // a sentence: why "auto" did not end with TetGen; empty where it did
  bool approximated = false;  // the boundary does not keep the surface exactly
};

/// Fills a surface with tets of good shape.
///
/// Coarse triangles are split first, so that the size of tets follows the target and not the input.
/// TetGen keeps the form of the surface where that gives usable tets. Where it does not, because
/// triangles are too narrow or too many for tets of this size, the surface is simplified first,
/// within 5 % of a tet's edge or less, with a warning "tetrahedralize.simplified". Isosurface
/// stuffing approximates it: its boundary is a closed manifold without self-intersections around
/// the points with winding number over 1/2 (mesh/winding_number.h); how far it is from the surface,
/// measure with mesh/surface_distance.h. Where "auto" falls back on stuffing there is a warning
/// "tetrahedralize.stuffed" with the reason. Shells that are turned inside out bound cavities,
/// which stay empty. The number of tets comes within about 15 % of the target where the surface
/// allows; a surface whose details force more is warned about ("tetrahedralize.more_tets"). TetGen
/// gives equal output for equal input on every platform, stuffing on one platform only.
/// @param surface  mm, finite, indices in range. For TetGen the border of a solid (mesh/validate.h)
/// @param defect   why the surface is no valid border of a solid, as a sentence; empty for a valid
///                 one. With a defect "auto" does not try TetGen, which may not survive it.
/// @throws Error "tetrahedralize.failed" if TetGen was asked for by name and the surface has a
///         defect or TetGen fails on it, "tetrahedralize.empty" if the surface encloses nothing,
///         "tetrahedralize.unavailable" if TetGen was asked for in a build without it
/// @throws Cancelled
Tetrahedralization tetrahedralize(const TriMesh& surface, const TetrahedralizeParams& params,
                                  Context& ctx, const std::string& defect = {});

}  // namespace s3
