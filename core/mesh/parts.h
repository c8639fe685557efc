// Several parts in one file: which of them keep together, and how each gets onto the plate.
#pragma once
#include <string>
#include <vector>

#include "base/context.h"
#include "mesh/placement.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// Two parts that touch, overlap, or lie one inside the other.
struct PartContact {
  Index first, second;  // first < second
  Vec3 place;           // mm
};

/// Enough contacts to connect all parts that keep together (at most one fewer than there are
/// parts). Exact; touching counts. Near-linear in the triangles.
/// @param part_of_triangle  #F, in [0, parts)
std::vector<PartContact> part_contacts(const TriMesh& mesh,
                                       const std::vector<Index>& part_of_triangle, Index parts,
                                       const Context& ctx);

/// Puts each part of a file onto the plate, as the parts of a plate are meant: the file's heights
/// are forgotten, x and y stay. Parts that touch, overlap or contain each other keep their places
/// among each other and are warned about ("mesh.merged_parts"), as they are printed as one body.
/// Warns "mesh.dropped_parts" when parts were moved; where this would push one part into another,
/// all stay where the file has them ("mesh.parts_collide").
/// @param surface       in the file's frame; its parts are moved
/// @param orientations  gets what a search found (see placement())
/// @return `params`, with the rotation that a search found written out: to be used with the moved
/// surface
/// @throws Error as placement()
InputParams stand_parts(TriMesh& surface, const std::vector<Index>& part_of_triangle,
                        const std::vector<std::string>& part_names, const InputParams& params,
                        std::vector<Orientation>& orientations, Context& ctx);

/// Warns ("mesh.floating_part") about bodies that start in the air while another stands on the
/// plate: pieces that hang together by vertices, are no cavities, and begin more than 0.1 % of the
/// height above the plate.
/// @param placed  closed, oriented, standing on z = 0
void warn_about_floating_parts(const TriMesh& placed, Context& ctx);

}  // namespace s3
