// Isosurfaces of G by marching tets: the raw material of layers (Sec. 4.2).
#pragma once
#include <vector>

#include "base/types.h"
#include "mesh/tet_mesh.h"
#include "mesh/tri_mesh.h"
#include "scalar_field/scalar_field.h"

namespace s3 {

/// G(x) = iso as a surface with boundary on the part's surface. Manifold, oriented along ∇G.
struct Isosurface {
  TriMesh surface;  // mm
  Directions
      normal;  // #V×3 unit: nodal gradients interpolated, so smoother than the triangles' normals
  std::vector<Index> source_tet;  // #F: the tet that the triangle crosses
};

/// Extracts isosurfaces of one field. The preparation is linear in the tets; an extraction touches
/// only tets whose range of G is near the value. Not for use from two threads at once.
class IsosurfaceExtractor {
 public:
  /// Keeps references to both arguments: they must outlive the extractor.
  IsosurfaceExtractor(const TetMesh& rest, const ScalarField& field);

  double min_value() const { return min_value_; }
  double max_value() const { return max_value_; }

  /// Vertices with G ≥ iso count as above, so a value met exactly by vertices needs no special
  /// case; crossing points keep 1e-4 of the edge's length away from its ends, so that no triangle
  /// is without area.
  Isosurface extract(double iso);

 private:
  void build_edges();
  void build_bins();
  void build_nodal_gradients();
  Index crossing(Index edge, double iso, Isosurface& out);

  const TetMesh& rest_;
  const ScalarField& field_;
  double min_value_ = 0, max_value_ = 0;
  Pairs edges_;                   // #E×2, first < second
  std::vector<Index> tet_edges_;  // #T×6
  std::vector<Index> bin_begin_;  // offsets into bin_tets_
  std::vector<Index> bin_tets_;   // tets whose range meets the bin, ascending
  double bin_width_ = 1;
  Points nodal_gradient_;           // #V×3
  std::vector<Index> edge_vertex_;  // #E: scratch, vertex of the running extraction or −1
  std::vector<Index> used_edges_;   // scratch: the edge of each output vertex
};

}  // namespace s3
