// How well shaped the tets of a mesh are.
#pragma once
#include <vector>

#include "mesh/tet_mesh.h"

namespace s3 {

struct TetQuality {
  double min_dihedral = 0;       // rad, the smallest of all tets
  double max_dihedral = 0;       // rad
  double mean_min_dihedral = 0;  // rad, mean over tets of their smallest angle
  Index tets_below_10_deg = 0;   // tets with a dihedral angle under 10°
  double min_volume = 0;         // mm³
  double max_volume = 0;         // mm³
  std::vector<Vec3>
      worst_places;  // mm, centroids of up to ten tets with the smallest angles, worst first
};

/// Smallest and largest of a tet's six dihedral angles, rad.
struct DihedralRange {
  double min, max;
};
DihedralRange dihedral_range(const TetMesh& mesh, Index t);

/// The smallest sine of a tet's dihedral angles; negative for a tet that is turned over.
double least_sine(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

TetQuality tet_quality(const TetMesh& mesh);

}  // namespace s3
