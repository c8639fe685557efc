// stress.csv: the stress tensors in the form of the paper's authors, which read_stress() reads.
#pragma once
#include <string>
#include <vector>

#include "fea/stress.h"

namespace s3 {

/// Rows `index,maxPrincipal,S11,S22,S33,S12,S13,S23`, indices from 1, MPa, all digits.
/// @param field  with tensors
/// @param order  row i of the file is tet order[i]; empty keeps the mesh's order
std::string write_stress_csv(const StressField& field, const std::vector<Index>& order);

}  // namespace s3
