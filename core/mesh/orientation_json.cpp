#include "mesh/orientation_json.h"

#include <nlohmann/json.hpp>

namespace s3 {

nlohmann::ordered_json to_json(const std::vector<Orientation>& orientations) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Orientation& o : orientations)
    json.push_back({{"rotate", o.rotate},
                    {"overhang_area_mm2", o.overhang_area},
                    {"support_volume_mm3", o.support_volume},
                    {"contact_area_mm2", o.contact_area},
                    {"height_mm", o.height},
                    {"tipping_deg", o.tipping_deg},
                    {"stable", o.stable}});
  return json;
}

}  // namespace s3
