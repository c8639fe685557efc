// A machine profile as JSON, the inverse of parse_machine_profile().
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "motion/machine_profile.h"

namespace s3 {

/// All keys of the axes that the machine has, angles in degrees. `inherits` is "cartesian", which
/// has no others.
nlohmann::ordered_json to_json(const MachineProfile& machine);

}  // namespace s3
