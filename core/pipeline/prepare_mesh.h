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

/// A surface file: cleaned, checked and placed. Fills model, placement and surface.
/// @throws Error as require_valid_surface() and placement()
void prepare_surface(ModelFile file, const InputParams& params, Artifacts& artifacts, Context& ctx);

}  // namespace s3
