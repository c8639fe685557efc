// Orientations as they stand in report.json and in the output of `s3slice inspect`.
#pragma once
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "mesh/orientation.h"

namespace s3 {

/// An array, in the order given; each with `rotate`, `overhang_area_mm2`, `support_volume_mm3`,
/// `contact_area_mm2`, `height_mm`, `tipping_deg` and `stable`.
nlohmann::ordered_json to_json(const std::vector<Orientation>& orientations);

}  // namespace s3
