// Faces that do not bound a solid: doubled triangles, flaps, walls inside a body; and the direction
// that triangles face.
#pragma once
#include "base/context.h"
#include "mesh/tri_mesh.h"
#include "mesh/validate.h"

namespace s3 {

/// Of triangles with the same three corners one is left, or none: sheets of two layers that face
/// opposite ways bound nothing where they are walls or flaps of a body.
/// @return the triangles that went
Defect remove_duplicate_triangles(TriMesh& mesh);

/// Turns triangles so that neighbours agree: in each part that hangs together by edges with two
/// triangles, the side with less area is turned.
/// @return the triangles that were turned
Defect turn_to_neighbours(TriMesh& mesh);

/// Removes the parts between edges of more than two triangles that have solid on both sides, or on
/// neither, by the winding number of the rest.
/// @return the triangles that went
Defect remove_inner_sheets(TriMesh& mesh, const Context* ctx);

}  // namespace s3
