// Curved layers: isosurfaces of G, cut where they would be too thin, in the order in which they are
// printed (Sec. 4.2).
#pragma once
#include <vector>

#include "base/types.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// One connected component of a layer: what is printed without leaving the surface. Triangles are
/// counter-clockwise seen from the nozzle, i.e. their normals agree with ∇G.
struct Layer {
  TriMesh surface;     // remeshed isosurface, mm
  Directions normal;   // #V×3, from ∇G, smooth: the nozzle stands against it
  Values thickness;    // #V mm: distance to the material below (or the plate)
  Values bead_height;  // #V mm: of the part down to the material, along −n (bead_height.h)
  std::vector<Index> source_tet;  // #F: a tet that the triangle lies in
  double iso_value = 0;           // of G, mm
  Index layer = 0;                // number of the isosurface, ascending with iso_value
  bool partial = false;  // the isosurface was cut because it would have been too thin elsewhere
  std::vector<Index>
      rests_on;  // positions in LayerStack::layers of the components below that carry this one
};

struct LayerStack {
  std::vector<Layer> layers;  // components in print order: everything in rests_on stands before
  Index isosurfaces = 0;      // how many different iso values

  double unsupported_area = 0;  // mm² of layers farther than d_max from anything printed before
  std::vector<Vec3> unsupported_places;  // one for each connected piece of it
  double dropped_area = 0;  // mm² not printed: too small for a bead, or rims just beyond d_max
  std::vector<Vec3> dropped_places;  // one for each piece
};

}  // namespace s3
