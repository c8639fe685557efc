// fields.vtu: the tet mesh with its fields as VTK XML, for ParaView, meshio and `s3slice evaluate`.
#pragma once
#include <string>
#include <vector>

#include "fea/stress.h"
#include "mesh/tet_mesh.h"
#include "outer_loop/deformer.h"

namespace s3 {

/// Which rows of a mesh a file lists in which order: row i of the file is row order[i] of the mesh.
/// Empty keeps the order.
struct FileOrder {
  std::vector<Index> vertices;
  std::vector<Index> tets;
};

/// Point data G (mm), deformed (3, mm); cell data lpd (3), quaternion (4: x y z w) and, with a
/// stress field, tau_max (3), sigma_max (MPa), critical (0/1) and, where the field has tensors,
/// stress (6, MPa: xx yy zz xy yz xz, the order of VTK).
///
/// Unstructured grid, little endian, arrays inline as base64 with UInt64 headers, all numbers in
/// double precision.
/// @param rest    the rest frame: mm, z up
/// @param stress  may be null
/// @param order   of the model file, for meshes that were renumbered
std::string write_fields_vtu(const TetMesh& rest, const DeformResult& result,
                             const StressField* stress, const FileOrder& order);

}  // namespace s3
