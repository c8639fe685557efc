// How much support a print needs: the space below its overhangs (Sec. 5.2).
#pragma once
#include <vector>

#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"

namespace s3 {

/// Volume of the vertical columns under faces that overhang their layer by more than 45°, down to
/// the part or the plate (z = the mesh's lowest point), mm³.
///
/// For planar layers (d = z) this is the classic support volume. For curved layers a face that
/// violates its own layer's 45° still gets a vertical column: an approximation, as real support
/// would follow the layers; faces that violate but look upward have no column. Each face is sampled
/// at points no further apart than 1/200 of the mesh's diagonal.
/// @param print_direction  #T×3 unit vectors
double support_volume(const TetMesh& rest, const ObjectiveField& objectives,
                      const Directions& print_direction, Context& ctx);

}  // namespace s3
