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

/// The way by which water that rises from the plate would come to each vertex: a flood over the
/// lowest passes, as on terrain (Barnes et al. 2014, "Priority-flood"). O(#T + #V log #V).
struct Flood {
  std::vector<Index> from;  // #V: the vertex before, −1 on the plate and where no way leads
  Values level;             // #V: the highest value on the way; above the value within a basin
};

/// @param least_slope  sine of the steepest way down that layers of the machine can follow
Flood flood_from_plate(const TetMesh& rest, const FieldOperators& operators,
                       const ObjectiveField& objectives, const Values& value, double least_slope);

/// Raises the vertices of basins no deeper than `depth` just enough that each of them lies above
/// one that comes before it: islands too shallow to matter are gone. Deeper ones stay.
/// O(#T + #V log #V).
/// @param rise  of G for each mm of the way, on vertices that are raised
/// @return #V
Values drain_shallow_basins(const TetMesh& rest, const FieldOperators& operators,
                            const ObjectiveField& objectives, const Values& value, double depth,
                            double rise);

}  // namespace s3
