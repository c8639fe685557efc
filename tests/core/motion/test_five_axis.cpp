#include <doctest/doctest.h>

#include <cmath>

#include "base/units.h"
#include "motion/five_axis.h"

using namespace s3;

namespace {

Vec3 direction(double tilt_deg, double azimuth_deg) {
  const double t = radians(tilt_deg), a = radians(azimuth_deg);
  return {std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), std::cos(t)};
}

double angle(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Waypoints in a row with the given normals.
Waypoints make_row(const std::vector<Vec3>& normals) {
  Waypoints w;
  const auto n = static_cast<Eigen::Index>(normals.size());
  w.position.resize(n, 3);
  w.normal.resize(n, 3);
  w.tangent.resize(n, 3);
  w.width.setConstant(n, 1);
  w.height.setConstant(n, 0.5);
  w.extrusion.setConstant(n, 0.2);
  w.speed.setConstant(n, 10);
  for (Eigen::Index i = 0; i < n; ++i) {
    w.position.row(i) = Vec3(10 + 0.5 * static_cast<double>(i), 5, 20);
    w.normal.row(i) = normals[static_cast<std::size_t>(i)];
    w.tangent.row(i) = Vec3(1, 0, 0);
    w.component.push_back(0);
    w.layer.push_back(0);
    w.path.push_back(0);
    w.kind.push_back(PathKind::wall);
    w.travel.push_back(i == 0 ? 1 : 0);
  }
  return w;
}

}  // namespace

TEST_CASE("forward kinematics undo inverse kinematics on every bundled machine") {
  for (const char* name : {"table-bc-duet", "head-ab"}) {
    CAPTURE(name);
    const MachineProfile machine = bundled_machine(name);
    for (double tilt = 0; tilt <= 70; tilt += 7)
      for (double azimuth = -180; azimuth <= 180; azimuth += 20) {
        const TipPose tip = {Vec3(12, -7, 30), direction(tilt, azimuth)};
        const TipPose back = forward_kinematics(machine, inverse_kinematics(machine, tip, {}));
        CHECK((back.position - tip.position).norm() < 1e-9);
        CHECK(angle(back.normal, tip.normal) <= kNormalTolerance + 1e-9);
      }
  }
}

TEST_CASE("a table tilted by hand reaches where it should") {
  MachineProfile machine = bundled_machine("table-bc-duet");
  machine.pivot = Vec3(0, 0, -10);
  // B = 90° about y: what pointed along −x points up. The plate's origin, 10 above the axis, goes
  // to +x by 10.
  MachinePose pose;
  pose.b = kPi / 2;
  pose.xyz = Vec3(10, 0, -10);
  const TipPose tip = forward_kinematics(machine, pose);
  CHECK(tip.position.norm() < 1e-12);
  CHECK((tip.normal - Vec3(-1, 0, 0)).norm() < 1e-12);
  // C = 90°: part's +x axis points along machine's +y.
  pose = {};
  pose.c = kPi / 2;
  pose.xyz = Vec3(0, 3, 1);
  CHECK((forward_kinematics(machine, pose).position - Vec3(3, 0, 1)).norm() < 1e-12);
}

TEST_CASE("a head tilted by hand moves its pivot") {
  MachineProfile machine = bundled_machine("head-ab");
  machine.pivot = Vec3(0, 0, 50);
  // The nozzle's axis along +x: B = 90°, the pivot stands 50 beside the tip, and X Y Z, 0 in
  // upright pose, moves along.
  const MachinePose pose = inverse_kinematics(machine, {Vec3(1, 2, 3), Vec3(1, 0, 0)}, {});
  CHECK(pose.b == doctest::Approx(kPi / 2));
  CHECK((pose.xyz - Vec3(51, 2, -47)).norm() < 1e-9);
}

TEST_CASE("C is unwrapped along a path that circles the axis three times") {
  const MachineProfile machine = bundled_machine("table-bc-duet");
  std::vector<Vec3> normals;
  for (int i = 0; i <= 360; ++i) normals.push_back(direction(30, 3.0 * i));
  Context ctx;
  const MachineMotion motion = plan_motion(make_row(normals), machine, ctx);
  CHECK(std::abs(motion.pose.back().c - motion.pose.front().c) ==
        doctest::Approx(6 * kPi).epsilon(0.01));
  for (std::size_t m = 1; m < motion.pose.size(); ++m) {
    CHECK(std::abs(motion.pose[m].c - motion.pose[m - 1].c) < radians(3.1));
    CHECK(std::abs(motion.pose[m].b - motion.pose[m - 1].b) < radians(3.1));
  }
  CHECK(ctx.warnings.empty());
}

TEST_CASE("directions that pass by the pole neither flip C nor make it spin") {
  const MachineProfile machine = bundled_machine("table-bc-duet");
  Context ctx;
  for (const double miss : {0.0, 1e-12, 1e-6, 1e-3}) {
    CAPTURE(miss);
    std::vector<Vec3> normals;
    for (int i = -20; i <= 20; ++i) normals.push_back(Vec3(0.02 * i, miss, 1).normalized());
    const MachineMotion motion = plan_motion(make_row(normals), machine, ctx);
    double most = 0;
    for (std::size_t m = 1; m < motion.pose.size(); ++m)
      most = std::max(most, std::abs(motion.pose[m].c - motion.pose[0].c));
    CHECK(most < radians(2));
    CHECK(motion.pose.front().b * motion.pose.back().b < 0);
  }
  // Noise about the vertical: the table stands still.
  std::vector<Vec3> normals;
  for (int i = 0; i < 50; ++i) normals.push_back(direction(0.4, 137.0 * i));
  const MachineMotion motion = plan_motion(make_row(normals), machine, ctx);
  for (const MachinePose& pose : motion.pose) CHECK(pose.c == motion.pose[0].c);
}

TEST_CASE("on the way between waypoints the tip stays on its line") {
  const MachineProfile machine = bundled_machine("table-bc-duet");
  std::vector<Vec3> normals = {direction(0, 0), direction(40, 70), direction(40, -80),
                               direction(10, 20)};
  const Waypoints w = make_row(normals);
  Context ctx;
  const MachineMotion motion = plan_motion(w, machine, ctx);
  CHECK(motion.pose.size() > 50);
  double extruded = 0;
  for (std::size_t m = 0; m < motion.pose.size(); ++m) {
    const Vec3 p = forward_kinematics(machine, motion.pose[m]).position - motion.part_offset;
    CHECK(std::abs(p.y() - 5) < 1e-9);
    CHECK(std::abs(p.z() - 20) < 1e-9);
    extruded += motion.extrusion(static_cast<Eigen::Index>(m));
    if (m == 0) continue;
    // No axis is faster than it can be, and controllers that run the axes evenly leave the line
    // only a little.
    const double t = motion.duration(static_cast<Eigen::Index>(m));
    CHECK(std::abs(motion.pose[m].c - motion.pose[m - 1].c) <= machine.c.speed * t + 1e-9);
    MachinePose middle;
    middle.xyz = 0.5 * (motion.pose[m].xyz + motion.pose[m - 1].xyz);
    middle.b = 0.5 * (motion.pose[m].b + motion.pose[m - 1].b);
    middle.c = 0.5 * (motion.pose[m].c + motion.pose[m - 1].c);
    const Vec3 q = forward_kinematics(machine, middle).position - motion.part_offset;
    CHECK(std::hypot(q.y() - 5, q.z() - 20) < 0.05);
  }
  CHECK(extruded == doctest::Approx(0.2 * 3));
}

TEST_CASE("waypoints out of an axis' range are named") {
  MachineProfile machine = bundled_machine("table-bc-duet");
  machine.b.min = radians(-30);
  machine.b.max = radians(30);
  Context ctx;
  plan_motion(make_row({direction(0, 0), direction(20, 0), direction(50, 0)}), machine, ctx);
  REQUIRE(ctx.warnings.size() == 1);
  CHECK(ctx.warnings[0].code == "motion.axis_limit");
  CHECK(ctx.warnings[0].message.find("waypoint 2") != std::string::npos);
  CHECK(ctx.warnings[0].message.find("axis B") != std::string::npos);
  // A table that tilts to one side only reaches all directions by turning C.
  machine.b = {radians(-1), radians(60), 1};
  Context other;
  const MachineMotion motion = plan_motion(
      make_row({direction(20, 10), direction(50, 20), direction(50, 160)}), machine, other);
  CHECK(other.warnings.empty());
  for (const MachinePose& pose : motion.pose) CHECK(pose.b > radians(-1));
}
