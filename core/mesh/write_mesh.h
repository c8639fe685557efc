// Model files out: for tools, tests and exchange. Everything that these write, read_model() reads
// back.
#pragma once
#include <string>

#include "base/types.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// Binary STL; coordinates become single precision.
std::string write_stl(const TriMesh& mesh);
/// Text formats; coordinates keep all their digits.
std::string write_obj(const TriMesh& mesh);
std::string write_off(const TriMesh& mesh);
/// The authors' volume format.
std::string write_tet(const Points& vertices, const Tets& tets);

/// Appends the shortest of %.15g, %.16g, %.17g that reads back as the same number.
void append_number(std::string& text, double value);

}  // namespace s3
