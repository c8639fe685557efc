// What the slicer knows of a machine. Bundled profiles are compiled in; others are read from JSON.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "base/types.h"
#include "params/param_info.h"
#include "toolpaths/make_toolpaths.h"
#include "waypoints/make_waypoints.h"

namespace s3 {

struct MachineParams {
  std::string machine = "table-bc-duet";
};

template <class Visitor>
void describe(Visitor& v, MachineParams& p) {
  v(p.machine,
    ParamInfo{.key = "machine",
              .label = "Machine",
              .unit = "",
              .doc = "Name of a bundled machine profile, or path of a profile file (JSON).",
              .stage = Stage::motion});
}

enum class Kinematics {
  cartesian,  // three axes: max_tilt is what the head's cone allows
  table_bc,   // table tilts about B (y) and turns about C (z)
  head_ab     // head tilts about A (x) and B (y)
};

struct AxisLimit {
  double min = 0, max = 0;  // mm or rad
  double speed = 0;         // mm/s or rad/s

  bool operator==(const AxisLimit&) const = default;
};

struct MachineProfile {
  std::string name;
  std::string description;
  Kinematics kinematics = Kinematics::table_bc;
  double max_tilt = 0;         // rad from z that ∇G may reach: default of deform.max_tilt
  double head_cone_angle = 0;  // rad: θ, apex angle of the cone that bounds the head (Sec. 2.2.1)
  Vec3 pivot = Vec3::Zero();   // table_bc: a point of the B axis in plate coordinates, mm; head_ab:
                               // tip → pivot
  AxisLimit x, y, z, a, b, c;
  double filament_diameter = 1.75;    // mm
  double max_flow = 0;                // mm³/s of the hot end
  double print_speed = 0;             // mm/s, tip
  double travel_speed = 0;            // mm/s, tip
  double retract = 0;                 // mm of filament
  double retract_speed = 0;           // mm/s
  double nozzle_temperature = 0;      // °C
  double bed_temperature = 0;         // °C
  double filament_density = 1.24e-3;  // g/mm³
  std::vector<std::string> programs;  // files that this machine wants: "program.gcode", …
  std::vector<std::string> start_gcode, end_gcode;

  bool operator==(const MachineProfile&) const = default;
};

/// Names of the bundled profiles.
std::vector<std::string> bundled_machines();
/// @throws Error "machine.unknown" that lists the bundled names
MachineProfile bundled_machine(std::string_view name);
/// A profile from JSON text; missing keys take the value of the profile named by "inherits"
/// (required). Keys are those of MachineProfile with angles in degrees (`max_tilt_deg`,
/// `head_cone_angle_deg`; limits and speeds of a, b, c).
/// @throws Error "machine.bad_profile" naming key, value and range
MachineProfile parse_machine_profile(std::string_view json, std::string_view file_name);

/// What the waypoints need to know of machine and job.
/// @param width  bead width, mm: travels keep this distance from what is printed
WaypointSettings waypoint_settings(const MachineProfile& machine, const ToolpathParams& toolpath,
                                   double width);

}  // namespace s3
