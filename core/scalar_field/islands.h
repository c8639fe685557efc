// Islands: places where the layers start in the air.
#pragma once
#include <vector>

#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"
#include "scalar_field/field_operators.h"

namespace s3 {

/// A local minimum of G away from the plate: material that would start in the air.
struct Island {
  Vec3 place = Vec3::Zero();  // centroid of the minimum's vertices, mm
  double volume = 0;          // mm³ printed before it merges with supported material
  double depth = 0;           // mm of G from its start to where it merges
};

/// Fills the solid in increasing G, as the printer does, and follows what is connected. A component
/// that begins without a vertex on the plate is an island until it joins an older or supported one.
/// O(#T + #V log #V).
/// @param value  #V
std::vector<Island> find_islands(const TetMesh& rest, const ObjectiveField& objectives,
                                 const Values& value);

/// The vertices of the islands alone, one ascending list for each flat minimum: cheap enough for
/// every few iterations.
std::vector<std::vector<Index>> find_minima(const TetMesh& rest, const FieldOperators& operators,
                                            const ObjectiveField& objectives, const Values& value);

}  // namespace s3
