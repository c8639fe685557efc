#include "export/gcode.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "export/number_text.h"

namespace s3 {
namespace {

constexpr int kLengthDecimals = 4;  // mm
constexpr int kAngleDecimals = 4;   // degrees
constexpr int kFilamentDecimals = 5;
constexpr std::size_t kMovesPerCheckpoint = 4096;

std::string fixed(double value, int decimals) {
  std::string text;
  append_fixed(text, value, decimals);
  return text;
}

class Program {
 public:
  Program(const Waypoints& waypoints, const MachineMotion& motion, const MachineProfile& machine,
          Context& ctx)
      : waypoints_(waypoints), motion_(motion), machine_(machine), ctx_(ctx) {
    text_.reserve(motion.pose.size() * 64 + 4000);
  }

  std::string write() {
    header();
    start();
    for (std::size_t m = 0; m < motion_.pose.size(); ++m) {
      if (m % kMovesPerCheckpoint == 0) ctx_.checkpoint();
      move(m);
    }
    end();
    return std::move(text_);
  }

 private:
  void line(std::string_view content) {
    text_ += content;
    text_ += '\n';
  }

  void header() {
    line("; S3 Slicer " S3_VERSION " for " + machine_.name + " (RepRapFirmware dialect)");
    line("; units mm, degrees, mm of filament; axes absolute, extruder relative");
    line(
        "; X Y Z B C = 0 puts the nozzle's tip on the middle of the plate; angles follow the "
        "right-hand rule");
    switch (machine_.kinematics) {
      case Kinematics::cartesian:
        line("; axes: X Y Z, no rotary axes");
        break;
      case Kinematics::table_bc:
        line(
            "; axes: the table turns about C (its z), the turning table tilts about B (machine y) "
            "around the pivot");
        line(
            "; a point p of the plate stands at Ry(B) (Rz(C) p - pivot) + pivot = X Y Z; positive "
            "C turns the table");
        line("; counter-clockwise seen from above, positive B lowers its +x side");
        break;
      case Kinematics::head_ab:
        line(
            "; axes: the head tilts about A (machine x) and, carried by A, about B (y); the nozzle "
            "points along");
        line(
            "; -Rx(A) Ry(B) z. X Y Z = tip + (Rx(A) Ry(B) - 1) pivot: no tool centre point control "
            "in the controller");
        break;
    }
    if (machine_.kinematics != Kinematics::cartesian) {
      line((machine_.kinematics == Kinematics::table_bc
                ? "; pivot, a point of the B axis on the plate's frame: "
                : "; pivot, from the tip to the point where A and B meet: ") +
           point(machine_.pivot));
      line("; rotary axes are unwrapped: switch any shortest-turn option of the controller off");
    }
    line("; part offset, added to the model's place on the plate: " + point(motion_.part_offset));
    double extruded = 0, seconds = 0;
    for (Eigen::Index m = 0; m < motion_.duration.size(); ++m) {
      extruded += motion_.extrusion(m);
      seconds += motion_.duration(m);
    }
    line("; filament " + fixed(extruded, 1) + " mm, time " + fixed(seconds / 60, 1) +
         " min without acceleration and retraction");
  }

  static std::string point(const Vec3& p) {
    std::string text;
    for (int k = 0; k < 3; ++k) {
      text += k > 0 ? " " : "";
      text += "XYZ"[k];
      append_fixed(text, p(k), kLengthDecimals);
    }
    return text;
  }

  void start() {
    line("G21");
    line("G90");
    line("M83");
    if (machine_.bed_temperature > 0) line("M140 S" + fixed(machine_.bed_temperature, 0));
    if (machine_.nozzle_temperature > 0) line("M104 S" + fixed(machine_.nozzle_temperature, 0));
    for (const std::string& command : machine_.start_gcode) line(command);
    if (machine_.bed_temperature > 0) line("M190 S" + fixed(machine_.bed_temperature, 0));
    if (machine_.nozzle_temperature > 0) line("M109 S" + fixed(machine_.nozzle_temperature, 0));
    line("G94");
  }

  void end() {
    feed_per_minute();
    retract();
    if (machine_.nozzle_temperature > 0) line("M104 S0");
    if (machine_.bed_temperature > 0) line("M140 S0");
    for (const std::string& command : machine_.end_gcode) line(command);
  }

  void move(std::size_t m) {
    const auto w = static_cast<std::size_t>(motion_.waypoint[m]);
    const bool travel = waypoints_.travel[w] != 0;
    comment(w);
    if (travel)
      retract();
    else
      prime();
    const MachinePose& pose = motion_.pose[m];
    const bool turns = m == 0 || pose.a != last_.a || pose.b != last_.b || pose.c != last_.c;
    const double duration = motion_.duration(static_cast<Eigen::Index>(m));
    const double length = (pose.xyz - last_.xyz).norm();
    if (m > 0 && turns && duration > 0)
      inverse_time();
    else
      feed_per_minute();
    text_ += travel && !inverse_time_ ? "G0" : "G1";  // G0 has no inverse time
    word('X', pose.xyz.x(), kLengthDecimals);
    word('Y', pose.xyz.y(), kLengthDecimals);
    word('Z', pose.xyz.z(), kLengthDecimals);
    if (machine_.kinematics == Kinematics::head_ab) word('A', degrees(pose.a), kAngleDecimals);
    if (machine_.kinematics != Kinematics::cartesian) word('B', degrees(pose.b), kAngleDecimals);
    if (machine_.kinematics == Kinematics::table_bc) word('C', degrees(pose.c), kAngleDecimals);
    if (!travel) {
      // What rounding leaves is carried on, so that the sum stays exact.
      filament_ += motion_.extrusion(static_cast<Eigen::Index>(m));
      constexpr double kStep = 1e-5;
      const double pushed = std::round(filament_ / kStep) * kStep;
      filament_ -= pushed;
      word('E', pushed, kFilamentDecimals);
    }
    if (inverse_time_)
      word('F', 60 / duration, 4);
    else if (m == 0 || duration == 0)
      word('F', 60 * machine_.travel_speed, 2);
    else
      word('F', std::max(0.01, 60 * length / duration), 2);
    text_ += '\n';
    last_ = pose;
  }

  void comment(std::size_t w) {
    if (waypoints_.component[w] != component_) {
      component_ = waypoints_.component[w];
      line("; LAYER " + std::to_string(waypoints_.layer[w]) + " component " +
           std::to_string(component_));
    }
    if (waypoints_.path[w] != path_) {
      path_ = waypoints_.path[w];
      line("; PATH " + std::to_string(path_) + " " + path_kind_name(waypoints_.kind[w]));
    }
  }

  void word(char letter, double value, int decimals) {
    text_ += ' ';
    text_ += letter;
    append_fixed(text_, value, decimals);
  }

  void inverse_time() {
    if (!inverse_time_) line("G93");
    inverse_time_ = true;
  }
  void feed_per_minute() {
    if (inverse_time_) line("G94");
    inverse_time_ = false;
  }
  void retract() { push_filament(true); }
  void prime() { push_filament(false); }
  void push_filament(bool back) {
    if (retracted_ == back || machine_.retract <= 0) return;
    retracted_ = back;
    feed_per_minute();
    text_ += "G1";
    word('E', back ? -machine_.retract : machine_.retract, kFilamentDecimals);
    word('F', 60 * machine_.retract_speed, 2);
    text_ += '\n';
  }

  const Waypoints& waypoints_;
  const MachineMotion& motion_;
  const MachineProfile& machine_;
  Context& ctx_;
  std::string text_;
  MachinePose last_;
  double filament_ = 0;
  Index component_ = -1, path_ = -1;
  bool inverse_time_ = false;
  bool retracted_ =
      true;  // the program before leaves it so, or the nozzle is empty: prime before the first bead
};

}  // namespace

std::string write_gcode(const Waypoints& waypoints, const MachineMotion& motion,
                        const MachineProfile& machine, Context& ctx) {
  return Program(waypoints, motion, machine, ctx).write();
}

}  // namespace s3
