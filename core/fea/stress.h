// The stress field that SR works on: imported here, computed by linear_elasticity.h (Sec. 2.1.2).
#pragma once
#include <vector>

#include "base/types.h"

namespace s3 {

struct StressField {
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>
      stress;              // #T×6 MPa: xx yy zz yz zx xy; empty if only directions are known
  Directions principal;    // #T×3, τ_max: direction of the largest principal stress
  Values principal_value;  // #T MPa, the largest principal stress (tension positive)
  std::vector<Index> critical_tets;  // S: ascending tet indices
};

}  // namespace s3
