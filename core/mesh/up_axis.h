// Whether a model was made with another axis up than the one it is taken with.
#pragma once
#include "base/context.h"
#include "mesh/placement.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// Warns ("mesh.up_axis") when nothing of the model lies flat on the plate with the up axis of
/// `params`, but a good part of it would with the other one. Silent when `params` turns the model.
/// @param surface  in the file's frame
void warn_about_up_axis(const TriMesh& surface, const InputParams& params, Context& ctx);

}  // namespace s3
