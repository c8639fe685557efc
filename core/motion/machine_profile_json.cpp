#include "motion/machine_profile_json.h"

#include <nlohmann/json.hpp>

#include "base/units.h"

namespace s3 {
namespace {

using Json = nlohmann::ordered_json;

Json linear(const AxisLimit& axis) {
  return {{"min", axis.min}, {"max", axis.max}, {"speed", axis.speed}};
}

Json rotary(const AxisLimit& axis) {
  return linear({degrees(axis.min), degrees(axis.max), degrees(axis.speed)});
}

const char* name_of(Kinematics kinematics) {
  switch (kinematics) {
    case Kinematics::cartesian:
      return "cartesian";
    case Kinematics::table_bc:
      return "table_bc";
    case Kinematics::head_ab:
      return "head_ab";
  }
  return "";
}

}  // namespace

Json to_json(const MachineProfile& m) {
  Json json = {{"inherits", "cartesian"},
               {"name", m.name},
               {"description", m.description},
               {"kinematics", name_of(m.kinematics)},
               {"max_tilt_deg", degrees(m.max_tilt)},
               {"head_cone_angle_deg", degrees(m.head_cone_angle)},
               {"pivot", {m.pivot.x(), m.pivot.y(), m.pivot.z()}},
               {"x", linear(m.x)},
               {"y", linear(m.y)},
               {"z", linear(m.z)}};
  // Axes that a machine does not have stay 0; their speed would be refused.
  if (m.a.speed > 0) json["a"] = rotary(m.a);
  if (m.b.speed > 0) json["b"] = rotary(m.b);
  if (m.c.speed > 0) json["c"] = rotary(m.c);
  json.update({{"filament_diameter", m.filament_diameter},
               {"max_flow", m.max_flow},
               {"print_speed", m.print_speed},
               {"travel_speed", m.travel_speed},
               {"retract", m.retract},
               {"retract_speed", m.retract_speed},
               {"nozzle_temperature", m.nozzle_temperature},
               {"bed_temperature", m.bed_temperature},
               {"filament_density", m.filament_density},
               {"programs", m.programs},
               {"start_gcode", m.start_gcode},
               {"end_gcode", m.end_gcode}});
  return json;
}

}  // namespace s3
