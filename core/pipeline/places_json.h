// Places in the part as they stand in report.json and in the output of `s3slice inspect`.
#pragma once
#include <vector>

#include <nlohmann/json.hpp>

#include "base/types.h"

namespace s3 {

/// [[x, y, z], …], mm.
inline nlohmann::ordered_json places_json(const std::vector<Vec3>& places) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Vec3& place : places) json.push_back({place.x(), place.y(), place.z()});
  return json;
}

}  // namespace s3
