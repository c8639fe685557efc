// How a partly held body could still move without strain.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "mesh/tet_mesh.h"

namespace s3 {

/// What a body can still do while axes of its vertices are held: "slide along x", "turn about z
/// through (1, 2, 3)", … Empty when it is held.
///
/// Tets that share a face move as one; pieces that only share edges or corners may hinge there, and
/// pieces apart from each other are looked at on their own.
/// @param held  #V, as in Loading
/// @throws Error "fea.loose_pieces" for too many pieces that hang together by points only
std::vector<std::string> free_motions(const TetMesh& mesh, const std::vector<std::uint8_t>& held);

}  // namespace s3
