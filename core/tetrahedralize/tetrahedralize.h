// From a closed surface to a tet mesh of a wanted size (Sec. 2): the only door to the mesher.
#pragma once
#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "mesh/tri_mesh.h"
#include "params/param_info.h"

namespace s3 {

struct TetrahedralizeParams {
  int target_tets = 100000;
};

template <class Visitor>
void describe(Visitor& v, TetrahedralizeParams& p) {
  v(p.target_tets, ParamInfo{.key = "mesh.target_tets",
                             .label = "Tets",
                             .unit = "",
                             .doc = "Wanted number of tets of the volume mesh; ignored for volume "
                                    "meshes, which are used as they are.",
                             .min = 100,
                             .max = 5e6,
                             .stage = Stage::tetrahedralize});
}

/// Fills a closed surface with tets of good shape; the surface keeps its form, its triangles may be
/// split.
///
/// Shells that are turned inside out bound cavities, which stay empty. The number of tets comes
/// within about 15 % of the target where the surface allows; a surface whose own triangles force
/// more is warned about
/// ("tetrahedralize.more_tets"). Equal input gives equal output on every platform.
/// @param surface  closed, manifold, oriented, without self-intersections (mesh/validate.h), mm
/// @return vertices and tets along a Morton curve, with topology
/// @throws Error "tetrahedralize.failed" if the surface intersects or nearly touches itself,
/// "tetrahedralize.empty" if
///         it encloses nothing, "tetrahedralize.unavailable" in a build without TetGen
/// @throws Cancelled
TetMesh tetrahedralize(const TriMesh& surface, const TetrahedralizeParams& params, Context& ctx);

}  // namespace s3
