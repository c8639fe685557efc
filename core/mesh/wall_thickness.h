// How thick a model's walls are, whether tets resolve them, and how many tets that takes (Sec. 2).
#pragma once
#include <vector>

#include "base/context.h"
#include "mesh/tet_mesh.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// A wall at one place: straight through the model from one side to the opposite one.
struct Wall {
  Vec3 from, to;  // mm
  double thickness() const { return (to - from).norm(); }
};

struct WallThickness {
  /// Thinnest first. Each stands for 1/samples of the surface's area.
  std::vector<Wall> walls;
  std::size_t samples = 0;

  /// A wall matters from this part of the surface on.
  static constexpr double kLeastArea = 0.005;
  /// The thinnest wall that matters: those that are thinner make up 0.5 % of the surface. Null when
  /// there are not that many.
  const Wall* thinnest() const;
};

/// From 16384 points spread over the surface, inward along the normal to the first triangle; a wall
/// where that triangle faces the other way within 30°. O((n + samples) log n).
/// @param surface  closed, counter-clockwise from outside, mm
WallThickness measure_walls(const TriMesh& surface, Context& ctx);

/// Tets with which a wall gets two across: even tets with an edge of 0.42 times its thickness
/// (measured with warn_about_thin_walls() on plates).
/// @param volume  of the model, mm³
double tets_for_wall(double volume, double thickness);

/// The target that resolves the thinnest wall that matters, from 30000 to 1000000 tets; 30000 for a
/// model without walls.
int automatic_target(const TriMesh& surface, const WallThickness& walls);

/// The walls that have a single tet across somewhere: one of the tets between the two sides has a
/// corner on each. Same order and shares of area as in `walls`.
WallThickness unresolved_walls(const TetMesh& mesh, const WallThickness& walls, Context& ctx);

/// Warns ("tetrahedralize.thin_wall") with the thickness and place of the thinnest unresolved wall
/// that matters and the target that would resolve it.
/// @param target  the number of tets that was asked for
void warn_about_thin_walls(const TetMesh& mesh, const WallThickness& walls, int target,
                           Context& ctx);

}  // namespace s3
