#include "motion/machine_profile.h"

#include <array>
#include <cmath>
#include <functional>
#include <set>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/units.h"

namespace s3 {
namespace {

using Json = nlohmann::json;

MachineProfile cartesian() {
  MachineProfile m;
  m.name = "cartesian";
  m.description = "Three axes; curved layers as steep as the cone of the head allows";
  m.kinematics = Kinematics::cartesian;
  m.head_cone_angle = radians(90);
  m.max_tilt = radians(25);
  m.x = {-150, 150, 200};
  m.y = {-150, 150, 200};
  m.z = {0, 300, 20};
  m.max_flow = 15;
  m.print_speed = 20;
  m.travel_speed = 80;
  m.retract = 1.5;
  m.retract_speed = 30;
  m.nozzle_temperature = 210;
  m.bed_temperature = 60;
  m.programs = {"program.gcode"};
  m.start_gcode = {"G28"};
  m.end_gcode = {"M84"};
  return m;
}

MachineProfile table_bc() {
  MachineProfile m = cartesian();
  m.name = "table-bc-duet";
  m.description = "RepRapFirmware machine; the table tilts about B and turns about C";
  m.kinematics = Kinematics::table_bc;
  m.max_tilt = radians(80);
  m.pivot = Vec3(0, 0, -35);
  m.x = {-200, 200, 150};
  m.y = {-200, 200, 150};
  m.z = {-200, 300, 30};
  m.b = {radians(-95), radians(95), radians(90)};
  // Without end stops; the limit keeps a cable from being wound up a hundred times.
  m.c = {radians(-36000), radians(36000), radians(180)};
  m.start_gcode = {"G28"};
  m.end_gcode = {"M84"};
  return m;
}

MachineProfile head_ab() {
  MachineProfile m = cartesian();
  m.name = "head-ab";
  m.description =
      "The head tilts about A (along x) and B (along y), A outermost; the part stands still";
  m.kinematics = Kinematics::head_ab;
  m.max_tilt = radians(60);
  m.pivot = Vec3(0, 0, 60);
  m.x = {-250, 250, 150};
  m.y = {-250, 250, 150};
  m.z = {-100, 350, 30};
  m.a = {radians(-75), radians(75), radians(120)};
  m.b = {radians(-75), radians(75), radians(120)};
  return m;
}

std::vector<MachineProfile> all_machines() {
  return {table_bc(), head_ab(), cartesian()};
}

[[noreturn]] void fail(std::string_view file, const std::string& what) {
  throw Error(ErrorKind::input, Stage::motion, "machine.bad_profile",
              "The machine profile " + std::string(file) + " " + what + ".",
              "Start from a bundled profile: {\"inherits\": \"table-bc-duet\", …}.");
}

/// Reads a JSON object key by key and remembers which keys exist, to name those that do not.
class ObjectReader {
 public:
  ObjectReader(const Json& object, std::string_view file, std::string prefix)
      : object_(object), file_(file), prefix_(std::move(prefix)) {
    if (!object.is_object())
      fail(file, "has no object at " + (prefix_.empty() ? std::string("its top") : prefix_));
  }

  /// @param unit  the stored value is the file's times this
  void number(const char* key, double& value, double low, double high, double unit = 1) {
    const Json* found = find(key);
    if (!found) return;
    if (!found->is_number())
      fail(file_, "has " + found->dump() + " at " + prefix_ + key + ", which must be a number");
    const double given = found->get<double>();
    if (!(given >= low && given <= high))
      fail(file_, "has " + found->dump() + " at " + prefix_ + key + ", outside [" +
                      Json(low).dump() + ", " + Json(high).dump() + "]");
    value = given * unit;
  }
  void text(const char* key, std::string& value) {
    const Json* found = find(key);
    if (!found) return;
    if (!found->is_string())
      fail(file_, "has " + found->dump() + " at " + prefix_ + key + ", which must be a text");
    value = found->get<std::string>();
  }
  void lines(const char* key, std::vector<std::string>& value) {
    const Json* found = find(key);
    if (!found) return;
    if (!found->is_array()) fail(file_, "must have a list of texts at " + prefix_ + key);
    value.clear();
    for (const Json& line : *found) {
      if (!line.is_string()) fail(file_, "must have a list of texts at " + prefix_ + key);
      value.push_back(line.get<std::string>());
    }
  }
  void point(const char* key, Vec3& value, double limit) {
    const Json* found = find(key);
    if (!found) return;
    if (!found->is_array() || found->size() != 3)
      fail(file_, "must have three numbers at " + prefix_ + key);
    for (std::size_t i = 0; i < 3; ++i) {
      if (!(*found)[i].is_number()) fail(file_, "must have three numbers at " + prefix_ + key);
      const double given = (*found)[i].get<double>();
      if (!(std::abs(given) <= limit))
        fail(file_, "has " + (*found)[i].dump() + " at " + prefix_ + key + ", outside ±" +
                        Json(limit).dump());
      value(static_cast<Eigen::Index>(i)) = given;
    }
  }
  void axis(const char* key, AxisLimit& value, bool rotary) {
    const Json* found = find(key);
    if (!found) return;
    ObjectReader reader(*found, file_, prefix_ + key + ".");
    const double unit = rotary ? kPi / 180 : 1;
    reader.number("min", value.min, -1e6, 1e6, unit);
    reader.number("max", value.max, -1e6, 1e6, unit);
    reader.number("speed", value.speed, 1e-3, 1e5, unit);
    reader.finish();
    if (value.min > value.max)
      fail(file_, "has a least value above the largest at " + prefix_ + key);
  }
  void finish() const {
    for (const auto& [key, unused] : object_.items())
      if (!known_.contains(key)) {
        std::string names;
        for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
        fail(file_, "has the unknown key " + prefix_ + key + "; known are " + names);
      }
  }

 private:
  const Json* find(const char* key) {
    known_.insert(key);
    const auto it = object_.find(key);
    return it == object_.end() ? nullptr : &*it;
  }
  const Json& object_;
  std::string_view file_;
  std::string prefix_;
  std::set<std::string> known_;
};

}  // namespace

std::vector<std::string> bundled_machines() {
  std::vector<std::string> names;
  for (const MachineProfile& m : all_machines()) names.push_back(m.name);
  return names;
}

MachineProfile bundled_machine(std::string_view name) {
  std::string names;
  for (MachineProfile& m : all_machines()) {
    if (m.name == name) return std::move(m);
    names += (names.empty() ? "" : ", ") + m.name;
  }
  throw Error(ErrorKind::input, Stage::motion, "machine.unknown",
              "There is no machine \"" + std::string(name) + "\"; bundled are " + names + ".",
              "Choose one of these, or give the path of a profile file.");
}

MachineProfile parse_machine_profile(std::string_view json, std::string_view file_name) {
  const Json root = Json::parse(json.begin(), json.end(), nullptr, /*allow_exceptions=*/false);
  if (root.is_discarded()) fail(file_name, "is not valid JSON");
  ObjectReader reader(root, file_name, "");
  std::string base;
  reader.text("inherits", base);
  if (base.empty()) fail(file_name, "does not name a bundled machine at \"inherits\"");
  MachineProfile m = bundled_machine(base);
  m.name = std::string(file_name);
  reader.text("name", m.name);
  reader.text("description", m.description);
  std::string kinematics;
  reader.text("kinematics", kinematics);
  if (kinematics == "cartesian")
    m.kinematics = Kinematics::cartesian;
  else if (kinematics == "table_bc")
    m.kinematics = Kinematics::table_bc;
  else if (kinematics == "head_ab")
    m.kinematics = Kinematics::head_ab;
  else if (!kinematics.empty())
    fail(file_name,
         "has the kinematics \"" + kinematics + "\"; known are cartesian, table_bc, head_ab");
  reader.number("max_tilt_deg", m.max_tilt, 0, 180, kPi / 180);
  reader.number("head_cone_angle_deg", m.head_cone_angle, 0, 180, kPi / 180);
  reader.point("pivot", m.pivot, 10000);
  reader.axis("x", m.x, false);
  reader.axis("y", m.y, false);
  reader.axis("z", m.z, false);
  reader.axis("a", m.a, true);
  reader.axis("b", m.b, true);
  reader.axis("c", m.c, true);
  reader.number("filament_diameter", m.filament_diameter, 0.1, 20);
  reader.number("max_flow", m.max_flow, 1e-3, 1e4);
  reader.number("print_speed", m.print_speed, 1e-2, 1e4);
  reader.number("travel_speed", m.travel_speed, 1e-2, 1e4);
  reader.number("retract", m.retract, 0, 1000);
  reader.number("retract_speed", m.retract_speed, 1e-2, 1e4);
  reader.number("nozzle_temperature", m.nozzle_temperature, 0, 600);
  reader.number("bed_temperature", m.bed_temperature, 0, 300);
  reader.number("filament_density", m.filament_density, 1e-5, 1);
  reader.lines("programs", m.programs);
  reader.lines("start_gcode", m.start_gcode);
  reader.lines("end_gcode", m.end_gcode);
  reader.finish();
  return m;
}

WaypointSettings waypoint_settings(const MachineProfile& machine, const ToolpathParams& toolpath,
                                   double width) {
  WaypointSettings settings;
  settings.spacing = toolpath.spacing;
  settings.chord_tolerance = 0.05 * width;
  settings.clearance = width;
  settings.filament_diameter = machine.filament_diameter;
  settings.print_speed = machine.print_speed;
  settings.travel_speed = machine.travel_speed;
  settings.max_flow = machine.max_flow;
  return settings;
}

}  // namespace s3
