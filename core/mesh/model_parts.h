// The parts of a surface file: which of its named pieces are solids of their own.
#pragma once
#include <string>
#include <vector>

#include "mesh/read_mesh.h"

namespace s3 {

/// Sets the parts of a surface from the pieces that the file names (OBJ objects and groups, solids
/// of a text STL). Pieces that share a point are one part, because groups are also used for the
/// faces or materials of one solid; parts are numbered by their first triangle and named after its
/// piece. Near-linear time.
/// @param piece_of_triangle  #F, in range of piece_names
void set_parts(ModelFile& model, const std::vector<Index>& piece_of_triangle,
               const std::vector<std::string>& piece_names);

}  // namespace s3
