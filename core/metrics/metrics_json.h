// METRICS of report.json.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "metrics/metrics.h"

namespace s3 {

/// All keys, in their order; null for what was not computed.
nlohmann::ordered_json to_json(const Metrics& metrics);

}  // namespace s3
