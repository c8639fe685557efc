// Closes holes: flat ones by a polygon, others by a curved cap.
#pragma once
#include "base/context.h"
#include "mesh/tri_mesh.h"
#include "mesh/validate.h"

namespace s3 {

struct FilledHoles {
  Defect flat, curved;  // at the middle of each hole
  Defect left_open;     // loops that no cap could be found for
  double area = 0;      // mm², of all caps, and of the loops left open
  double largest = 0;   // mm, across the largest hole
  Index first_new = 0;  // number of the first new triangle
};

/// Closes every loop of open edges. Loops in one plane that lie inside each other are filled
/// between them, as the end of a pipe is. Caps face as their surroundings do.
/// @param fair  curved caps are refined and continue the curvature around them; otherwise they are
///              the plain triangulation of the loop
FilledHoles fill_holes(TriMesh& mesh, bool fair, Context& ctx);

}  // namespace s3
