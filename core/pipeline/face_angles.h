// What views show of a result beside its arrays: angles on each face, places where the head gouges.
#pragma once
#include <vector>

#include "metrics/lpd_metrics.h"
#include "motion/machine_profile.h"
#include "pipeline/artifacts.h"
#include "pipeline/params.h"

namespace s3 {

/// Over the boundary faces of the rest mesh. The angles are those of lpd_angles(), whose figures
/// leave out the faces on the plate.
struct FaceAngles {
  Values support_free;         // #B degrees between n and d, in [0, 180]
  Values surface_quality;      // #B degrees between ±n and d, in [0, 90]
  std::vector<char> overhang;  // #B: 1 beyond objectives.alpha; 0 on the plate
  std::vector<char> stairs;    // #B: 1 farther than 10° from both ends; 0 on the plate
};

/// @param print_direction  #T×3 unit vectors, of the field or of planar layers
FaceAngles face_angles(const Artifacts& artifacts, const Params& params,
                       const Directions& print_direction);

/// Face pairs that count as gouging_pairs in the metrics.
struct GougingPlaces {
  Pairs pairs;               // #N×2 tets
  Points places;             // #N×3 mm: centroid of the shared face
  Values concave_deg;        // #N: by how much the layer is concave there
  double clearance_deg = 0;  // what the head leaves
};

GougingPlaces gouging_places(const Artifacts& artifacts, const MachineProfile& machine);

/// d of planar layers, for every tet: z.
Directions upright_directions(Index tets);

}  // namespace s3
