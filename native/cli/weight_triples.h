// The triples of weights that a sweep runs through.
#pragma once
#include <string>
#include <vector>

#include "objectives/objectives.h"

namespace s3::cli {

struct WeightTriple {
  double support_free = 0, strength = 0, surface_quality = 0;

  void set(ObjectiveParams& params) const {
    params.support_free = support_free;
    params.strength = strength;
    params.surface_quality = surface_quality;
  }
  bool operator==(const WeightTriple&) const = default;
};

/// All triples of multiples of 1/steps whose sum is 1, from SF alone to SQ alone.
std::vector<WeightTriple> triangular_grid(int steps);

/// "0.7,0.3,0" is SF, SR, SQ; several in a text are separated by semicolons. A triple that comes
/// twice counts once.
/// @throws Error "params.bad_weights" naming the triple
std::vector<WeightTriple> parse_triples(const std::vector<std::string>& texts);

}  // namespace s3::cli
