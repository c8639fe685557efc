// The field G whose isosurfaces are the layers (Sec. 2.3 step 5, Sec. 4.1): piecewise linear on the
// rest mesh.
#pragma once
#include "base/types.h"
#include "mesh/tet_mesh.h"

namespace s3 {

struct ScalarField {
  Values value;                // #V, G in mm: 0 on the plate
  Points gradient;             // #T×3, ∇G
  Directions print_direction;  // #T×3, ∇G/‖∇G‖ = LPD; zero where ∇G vanishes
};

/// Fills in gradients and print directions for values on the vertices.
ScalarField make_scalar_field(const TetMesh& rest, Values value);

}  // namespace s3
