// The body-centred cubic lattice: cubes' corners and centres, and the tets between them.
#pragma once
#include <array>

#include "base/types.h"

namespace s3 {

/// Corners (kind 0) and centres (kind 1) of cubes of edge `size`. A vertex has six long edges along
/// the axes to vertices of its kind, and eight short ones (√3/2 long) to the other kind. Each tet
/// has two long edges, one of each kind, and four short ones; its volume is size³/12.
struct BccLattice {
  Vec3 origin = Vec3::Zero();            // the first corner
  double size = 1;                       // mm
  std::array<Index, 3> counts{0, 0, 0};  // corners along each axis; centres alike

  struct Place {
    std::array<Index, 3> cell;
    int kind;
  };

  /// Number of vertices.
  Index count() const { return 2 * counts[0] * counts[1] * counts[2]; }
  bool contains(const Place& p) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (p.cell[k] < 0 || p.cell[k] >= counts[k]) return false;
    return true;
  }
  Index index(const Place& p) const {
    return 2 * ((p.cell[2] * counts[1] + p.cell[1]) * counts[0] + p.cell[0]) + p.kind;
  }
  Place place(Index v) const {
    const Index cell = v / 2;
    return {{cell % counts[0], cell / counts[0] % counts[1], cell / counts[0] / counts[1]}, v % 2};
  }
  Vec3 position(const Place& p) const {
    return origin + size * (Vec3(p.cell[0], p.cell[1], p.cell[2]) + Vec3::Constant(0.5 * p.kind));
  }
  Vec3 position(Index v) const { return position(place(v)); }
  /// True for an edge along an axis.
  static bool is_long(Index a, Index b) { return a % 2 == b % 2; }

  /// Each edge belongs to one of its ends: the one that lists it here. @return their number; 11 for
  /// a corner, 3 for a centre, fewer at the border
  int own_edges(Index v, std::array<Index, 11>& others) const;
  /// The tets that belong to a centre: around the edges to its three next centres.
  int own_tets(Index center, std::array<std::array<Index, 4>, 12>& tets) const;
};

/// A lattice around a box, with cubes of edge `size` and a margin of two; shifted by an odd
/// fraction of a cube, so that faces along the axes do not run through vertices.
/// @throws Error "tetrahedralize.too_thin" for more than 10⁸ vertices
BccLattice lattice_around(const Vec3& low, const Vec3& high, double size);

/// The smallest size for which lattice_around() succeeds.
double smallest_lattice_size(const Vec3& low, const Vec3& high);

}  // namespace s3
