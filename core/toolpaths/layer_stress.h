// The stress as a layer's toolpaths see it: τ_max of the tets, projected on the layer (Sec. 5.1).
#pragma once
#include <vector>

#include "fea/stress.h"
#include "layers/layer.h"

namespace s3 {

/// Per triangle of a layer.
struct LayerStress {
  Directions direction;  // #F×3 unit, in the triangle's plane; zero where τ_max is normal to it
  Values confidence;     // #F in [0, 1]: how well the stress defines that direction
  std::vector<char> critical;  // #F: the triangle lies in S
};

/// Confidence is the squared length of the projection times the anisotropy: where the two largest
/// principal stresses are alike, τ_max is any direction. Outside of S it is far lower, and falls
/// with the stress.
LayerStress project_stress(const Layer& layer, const StressField& stress);

/// Share of the layer's area in S.
double critical_share(const Layer& layer, const LayerStress& stress);

}  // namespace s3
