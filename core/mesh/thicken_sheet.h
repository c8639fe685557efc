// A sheet becomes a plate: surfaces that enclose nothing get the thickness that the user asks for.
#pragma once
#include "mesh/tri_mesh.h"

namespace s3 {

/// The surface at half the thickness on either side, closed along the rims. Where the sheet bends
/// more tightly than that, or crosses itself, so does the result.
/// @param sheet      any triangles; they are turned to agree with their neighbours
/// @param thickness  > 0, in the sheet's unit
TriMesh thicken_sheet(TriMesh sheet, double thickness);

}  // namespace s3
