// A load case on a mesh: which vertices are held and what force acts on each.
#pragma once
#include <cstdint>
#include <vector>

#include "base/context.h"
#include "fea/load_case.h"
#include "mesh/tet_mesh.h"

namespace s3 {

/// One right-hand side of linear_elasticity.h.
struct Loading {
  std::vector<std::uint8_t> held;  // #V: bit a is set where axis a is held
  Points displacement;             // #V×3 mm, read where held
  Points force;                    // #V×3 N
};

/// The boundary faces of a region, ascending. See load_case.h for which faces a shape takes.
/// @param stage  that asks
/// @throws Error "<stage>.empty_region" with the model's bounds and the nearest face
std::vector<Index> region_faces(const TetMesh& rest, const Region& region,
                                Stage stage = Stage::fea);

/// The tets of a region, ascending: those behind its faces, and those with their centroid in one of
/// its boxes, spheres and half-spaces.
/// @throws Error "fea.empty_region"
std::vector<Index> region_tets(const TetMesh& rest, const Region& region);

/// All cases of a file on a mesh that stands on the plate, checked: every case can be solved.
/// @throws Error "fea.empty_region"; "fea.unconstrained" when the part could still move as a rigid
/// body, with the movements; "fea.contradictory" for a vertex with two displacements or a force
/// that acts on held vertices only; "fea.no_load"
std::vector<Loading> apply_load_cases(const TetMesh& rest, const LoadCases& file, Context& ctx);

}  // namespace s3
