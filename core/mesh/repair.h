// Makes a surface the border of a solid, by the mildest means that work, and says what was done.
#pragma once
#include <string>
#include <vector>

#include "base/context.h"
#include "mesh/tri_mesh.h"
#include "mesh/validate.h"

namespace s3 {

/// One kind of change, for the user and for the views.
struct RepairChange {
  std::string code;      // stable, as "repair.holes"
  std::string sentence;  // "2 holes filled with flat faces, the largest 3.2 mm across"
  Index count = 0;
  std::vector<Vec3> places;  // mm, the first hundred
};

struct RepairResult {
  TriMesh surface;
  std::vector<RepairChange> changes;  // in the order of their making
  MeshReport report;                  // of the repaired surface
  /// The surface can be filled with tets as it is. Bodies may touch in common vertices and edges,
  /// which are then doubled.
  bool valid = false;
  std::string reason;  // why it is not valid, as a sentence; empty when it is
};

/// Steps, each only where something calls for it: triangles without coordinates dropped; equal
/// vertices welded, then open edges stitched within a tolerance; edges without length and triangles
/// without height collapsed; duplicates, flaps and walls inside removed; triangles turned to agree;
/// holes filled unless that crosses the surface; bodies that touch in an edge or a vertex taken
/// apart; shells without volume dropped; shells turned outward, or inward inside another
/// (cavities); small places where the surface crosses itself cut out and closed anew.
///
/// A surface that still crosses itself, or stays open, comes back mended as far as it goes with
/// `valid` false: it is ready for a mesher that follows the winding number.
/// A valid surface comes back as it is, but for vertices that nothing uses and details below a
/// millionth of its size. Near-linear time.
/// @param surface  indices in range; coordinates may be anything
/// @throws Error "mesh.empty" without triangles; "mesh.no_volume" where all of it is flat
/// @throws Cancelled
RepairResult repair_surface(TriMesh surface, Context& ctx);

}  // namespace s3
