// Π of Eq. 13: how far the print directions of a field are from what the objectives ask.
#pragma once
#include "base/context.h"
#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"

namespace s3 {

struct Residual {
  Values distance;  // #T, rad: D(∇G/‖∇G‖, H_e); 0 for tets that do not count
  Index tets = 0;   // |S ∪ B| without the tets of the plate contact
  double mean = 0;  // rad: the sum of Eq. 13 over `tets`; 0 when nothing is asked
};

/// Geodesic distances of the print directions to the feasible regions, without any margin. Tets
/// with a face on the plate are left out: their direction is given.
/// @param print_direction  #T×3 unit vectors; a zero row (a vanished gradient) counts as π
Residual residual(const ObjectiveField& objectives, const ObjectiveParams& params,
                  const Directions& print_direction, Context& ctx);

}  // namespace s3
