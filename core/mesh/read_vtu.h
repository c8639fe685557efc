// VTK XML unstructured grids (.vtu): a tet mesh with the values at its points and tets.
#pragma once
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/types.h"

namespace s3 {

/// A named array of a VTU file: rows × components, row by row.
struct VtuArray {
  int components = 1;
  std::vector<double> values;
};

struct VtuFile {
  Points vertices;                             // #V×3
  Tets tets;                                   // #T×4, file order
  std::map<std::string, VtuArray> point_data;  // #V rows each
  std::map<std::string, VtuArray> cell_data;   // #T rows each
};

/// Reads a file of linear tets (VTK cell type 10; other cells are an error), in one or several
/// pieces.
///
/// Arrays may be ascii, base64 ("binary") or appended (raw or base64), little endian, with UInt32
/// or UInt64 headers, of any number type. Compressed files are refused with a hint. Time and memory
/// O(bytes).
/// @throws Error "mesh.bad_file"
VtuFile read_vtu(std::span<const std::byte> bytes, std::string_view file_name);

}  // namespace s3
