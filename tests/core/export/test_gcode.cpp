#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/units.h"
#include "export/authors_waypoints.h"
#include "export/gcode.h"
#include "export/waypoint_csv.h"
#include "layer_shapes.h"
#include "toolpaths/make_toolpaths.h"

using namespace s3;

namespace {

Waypoints make_print(const MachineProfile& machine, Context& ctx) {
  LayerStack stack;
  stack.layers = {test::make_disc(6, 0.7), test::make_cap(12, 6, 0.7)};
  for (std::size_t i = 0; i < 2; ++i) {
    stack.layers[i].surface.vertices.col(2).array() += 3 + 3 * static_cast<double>(i);
    stack.layers[i].surface.vertices.col(0).array() += 40;
    stack.layers[i].layer = static_cast<Index>(i);
  }
  return make_waypoints(stack, make_toolpaths(stack, nullptr, {}, 1.0, ctx),
                        waypoint_settings(machine, {}, 1.0), ctx);
}

struct ParsedMove {
  MachinePose pose;
  double extrusion, seconds;
  bool travel;
};

/// A small interpreter of what a RepRapFirmware controller does with the program.
struct Interpreter {
  std::vector<ParsedMove> moves;
  double filament = 0, retraction = 0;
  int errors = 0;

  explicit Interpreter(const std::string& program) {
    std::istringstream lines(program);
    bool inverse = false, absolute = false, relative_e = false;
    MachinePose pose;
    double feed = 0;
    for (std::string line; std::getline(lines, line);) {
      line = line.substr(0, line.find(';'));
      std::istringstream words(line);
      std::string command;
      if (!(words >> command)) continue;
      if (command == "G93") inverse = true;
      if (command == "G94") inverse = false;
      if (command == "G90") absolute = true;
      if (command == "M83") relative_e = true;
      if (command != "G0" && command != "G1") continue;
      std::map<char, double> value;
      for (std::string word; words >> word;) value[word[0]] = std::atof(word.c_str() + 1);
      if (!absolute || !relative_e) ++errors;
      if (inverse && !value.count('F')) ++errors;
      if (value.count('F')) feed = value['F'];
      const bool moves_axes = value.count('X') > 0, extrudes = value.count('E') > 0;
      if (!moves_axes) {
        retraction += value['E'];
        if (inverse) ++errors;
        continue;
      }
      const Vec3 before = pose.xyz;
      pose.xyz = Vec3(value['X'], value['Y'], value['Z']);
      if (value.count('A')) pose.a = radians(value['A']);
      if (value.count('B')) pose.b = radians(value['B']);
      if (value.count('C')) pose.c = radians(value['C']);
      filament += value['E'];
      moves.push_back({pose, value['E'],
                       inverse ? 60 / feed : 60 * (pose.xyz - before).norm() / feed, !extrudes});
    }
  }
};

}  // namespace

TEST_CASE("programs of every machine give back the waypoints") {
  for (const std::string& name : bundled_machines()) {
    CAPTURE(name);
    const MachineProfile machine = bundled_machine(name);
    Context ctx;
    const Waypoints w = make_print(machine, ctx);
    const MachineMotion motion = plan_motion(w, machine, ctx);
    CHECK(ctx.warnings.empty());
    // In the middle of the plate although the model is not.
    CHECK(motion.part_offset.x() == doctest::Approx(-40).epsilon(0.001));
    const Interpreter program(write_gcode(w, motion, machine, ctx));
    CHECK(program.errors == 0);
    REQUIRE(program.moves.size() == motion.pose.size());
    CHECK(program.filament == doctest::Approx(w.extrusion.sum()).epsilon(1e-6));
    CHECK(std::abs(program.retraction) < 1e-9);  // as often back as forth
    double since = 0;
    Index arrived = 0;
    for (std::size_t m = 0; m < program.moves.size(); ++m) {
      const ParsedMove& move = program.moves[m];
      since += move.extrusion;
      if (m > 0 && motion.duration(static_cast<Eigen::Index>(m)) > 0)
        CHECK(move.seconds ==
              doctest::Approx(motion.duration(static_cast<Eigen::Index>(m))).epsilon(0.01));
      if (!motion.arrives[m]) continue;
      const Index i = motion.waypoint[m];
      CHECK(i == arrived++);
      const TipPose tip = forward_kinematics(machine, move.pose);
      CHECK((tip.position - motion.part_offset - Vec3(w.position.row(i))).norm() < 1e-3);
      if (machine.kinematics != Kinematics::cartesian)
        CHECK(tip.normal.dot(w.normal.row(i)) > std::cos(kNormalTolerance + 1e-5));
      CHECK(std::abs(since - w.extrusion(i)) < 2e-5);
      CHECK(move.travel == (w.travel[static_cast<std::size_t>(i)] != 0));
      since = 0;
    }
    CHECK(arrived == w.size());
  }
}

TEST_CASE("the tip's speed on the part is what the waypoints ask for where the axes can follow") {
  const MachineProfile machine = bundled_machine("table-bc-duet");
  Context ctx;
  const Waypoints w = make_print(machine, ctx);
  const MachineMotion motion = plan_motion(w, machine, ctx);
  const Interpreter program(write_gcode(w, motion, machine, ctx));
  std::vector<double> seconds(static_cast<std::size_t>(w.size()), 0);
  for (std::size_t m = 0; m < program.moves.size(); ++m)
    seconds[static_cast<std::size_t>(motion.waypoint[m])] += program.moves[m].seconds;
  // Slower only where an axis runs at its limit.
  std::vector<char> limited(static_cast<std::size_t>(w.size()), 0);
  for (std::size_t m = 1; m < motion.pose.size(); ++m) {
    const MachinePose &from = motion.pose[m - 1], &to = motion.pose[m];
    const double need = std::max({std::abs(to.xyz.x() - from.xyz.x()) / machine.x.speed,
                                  std::abs(to.xyz.y() - from.xyz.y()) / machine.y.speed,
                                  std::abs(to.xyz.z() - from.xyz.z()) / machine.z.speed,
                                  std::abs(to.b - from.b) / machine.b.speed,
                                  std::abs(to.c - from.c) / machine.c.speed});
    if (need > 0.999 * motion.duration(static_cast<Eigen::Index>(m)))
      limited[static_cast<std::size_t>(motion.waypoint[m])] = 1;
  }
  int kept = 0;
  for (Index i = 1; i < w.size(); ++i) {
    if (w.travel[static_cast<std::size_t>(i)]) continue;
    const double speed =
        (w.position.row(i) - w.position.row(i - 1)).norm() / seconds[static_cast<std::size_t>(i)];
    CHECK(speed < 1.01 * w.speed(i));
    if (!limited[static_cast<std::size_t>(i)]) CHECK(speed > 0.99 * w.speed(i));
    kept += !limited[static_cast<std::size_t>(i)];
  }
  CHECK(kept > 100);
}

TEST_CASE("the authors' text has y up, normals into the part and a file for each component") {
  Context ctx;
  const Waypoints w = make_print(bundled_machine("cartesian"), ctx);
  const std::vector<std::string> files = write_authors_waypoints(w, ctx);
  REQUIRE(files.size() == 2);
  Index next = 0;
  const auto skip = [&] {
    // Read back what lies on paths: travels carry no width except where they arrive.
    while (next < w.size() && w.width(next) == 0) ++next;
  };
  for (std::size_t k = 0; k < files.size(); ++k) {
    std::istringstream lines(files[k]);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      Vec3 p, n;
      REQUIRE(static_cast<bool>(words >> p.x() >> p.y() >> p.z() >> n.x() >> n.y() >> n.z()));
      skip();
      REQUIRE(next < w.size());
      // Their reader's rotation, (x, y, z) ↦ (x, −z, y).
      CHECK((Vec3(p.x(), -p.z(), p.y()) - Vec3(w.position.row(next))).norm() < 2e-6);
      CHECK((-Vec3(n.x(), -n.z(), n.y()) - Vec3(w.normal.row(next))).norm() < 2e-6);
      CHECK(w.component[static_cast<std::size_t>(next)] == static_cast<Index>(k));
      CHECK(n.y() < 0);
      ++next;
    }
  }
  skip();
  CHECK(next == w.size());
}

TEST_CASE("a quarter of a million waypoints are a line each") {
  Waypoints w;
  const Index n = 250000;
  w.position.setRandom(n, 3);
  w.position *= 80;
  w.normal.setRandom(n, 3);
  w.normal.rowwise().normalize();
  w.tangent = w.normal;
  for (Values* v : {&w.width, &w.height, &w.extrusion}) v->setConstant(n, 0.41237);
  w.speed.setConstant(n, 15);
  w.component.assign(n, 0);
  w.layer = w.path = w.component;
  w.kind.assign(n, PathKind::wall);
  w.travel.assign(n, 0);
  const std::string text = write_waypoint_csv(w);
  CHECK(text.size() > 20u * 1000 * 1000);
  Index lines = 0;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) lines += text[at] != '#';
  CHECK(lines == n + 1);  // below the names of the columns
  CHECK(text.back() == '\n');
}
