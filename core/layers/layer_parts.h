// Cutting layer surfaces: along a threshold, and into connected pieces (Sec. 4.2, Step 3).
#pragma once
#include <vector>

#include "layers/isosurface.h"

namespace s3 {

/// The part of a surface where the piecewise linear `value` (one a vertex) is not negative.
Isosurface cut_where_negative(const Isosurface& surface, const Values& value);

/// Connected components, in the order of their first triangle.
std::vector<Isosurface> split_components(const Isosurface& surface);

}  // namespace s3
