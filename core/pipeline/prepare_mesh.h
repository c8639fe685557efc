// From a model file to a mesh that stands on the plate.
#pragma once
#include "base/context.h"
#include "mesh/read_mesh.h"
#include "pipeline/artifacts.h"
#include "pipeline/params.h"

namespace s3 {

/// A volume file: its tets in the rest frame, renumbered along a Morton curve. Fills model,
/// placement, surface, rest and file_order.
/// @throws Error as make_tet_mesh() and placement()
void prepare_volume(ModelFile file, const InputParams& params, Artifacts& artifacts, Context& ctx);

/// A surface file: repaired and placed. Fills model, placement, given and surface.
/// @throws Error as repair_surface() and placement()
void prepare_surface(ModelFile file, const InputParams& params, Artifacts& artifacts, Context& ctx);

/// Tets for artifacts.given. Fills rest, filling, and, where the mesher could only approximate a
/// surface that is no border of a solid, surface and model.volume: from there on the rebuilt solid
/// is the model. Warns ("mesh.rebuilt") with the distance between the two.
/// @throws Error "mesh.no_volume" where the triangles enclose nothing; as tetrahedralize()
void fill_surface(const TetrahedralizeParams& params, Artifacts& artifacts, Context& ctx);

}  // namespace s3
