// Islands: places where the layers start in the air.
#pragma once
#include <vector>

#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "objectives/objectives.h"

namespace s3 {

/// A local minimum of G away from the plate: material that would start in the air.
struct Island {
  Vec3 place = Vec3::Zero();  // centroid of the minimum's vertices, mm
  double volume = 0;          // mm³ printed before it merges with supported material
};

/// The vertices where G has a local minimum away from the plate, one list for each connected flat
/// minimum.
struct FieldMinimum {
  std::vector<Index> vertices;  // ascending
  double volume = 0;            // as in Island
};

/// Fills the solid in increasing G, as the printer does, and follows what is connected. A component
/// that begins without a vertex on the plate is an island until it joins an older or supported one.
/// O(#T log #V).
/// @param value  #V
std::vector<FieldMinimum> find_minima(const TetMesh& rest, const ObjectiveField& objectives,
                                      const Values& value);

std::vector<Island> find_islands(const TetMesh& rest, const ObjectiveField& objectives,
                                 const Values& value);

}  // namespace s3
