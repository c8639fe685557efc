#include "motion/five_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/units.h"

namespace s3 {
namespace {

constexpr double kRotaryStep = radians(3);

Mat3 rotate(double angle, const Vec3& axis) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

double wrap_to(double angle, double near) {
  return angle + 2 * kPi * std::round((near - angle) / (2 * kPi));
}

bool within(const AxisLimit& limit, double value) {
  constexpr double kSlack = 1e-9;
  return value >= limit.min - kSlack && value <= limit.max + kSlack;
}

MachinePose inverse_table(const MachineProfile& machine, const TipPose& tip,
                          const MachinePose& before) {
  const Vec3& n = tip.normal;
  const double across = std::hypot(n.x(), n.y());
  const double slack =
      across > std::sin(kNormalTolerance) ? std::asin(std::sin(kNormalTolerance) / across) : kPi;
  MachinePose best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const double branch : {0.0, kPi}) {
    const double exact = wrap_to(-std::atan2(n.y(), n.x()) + branch, before.c);
    for (const double turn : {0.0, -2 * kPi, 2 * kPi}) {
      MachinePose pose;
      pose.c = std::clamp(before.c, exact + turn - slack, exact + turn + slack);
      const Vec3 turned = rotate(pose.c, Vec3::UnitZ()) * n;
      pose.b = -std::atan2(turned.x(), turned.z());
      double cost = std::abs(pose.c - before.c) + std::abs(pose.b - before.b);
      // Limits first; the caller reports what stays outside.
      if (!within(machine.b, pose.b) || !within(machine.c, pose.c)) cost += 1e6;
      if (cost < best_cost) best_cost = cost, best = pose;
    }
  }
  best.xyz = rotate(best.b, Vec3::UnitY()) *
                 (rotate(best.c, Vec3::UnitZ()) * tip.position - machine.pivot) +
             machine.pivot;
  return best;
}

MachinePose inverse_head(const MachineProfile& machine, const TipPose& tip,
                         const MachinePose& before) {
  const Vec3& n = tip.normal;
  MachinePose pose;
  pose.b = std::asin(std::clamp(n.x(), -1.0, 1.0));
  // A is undecided only where the head lies along x.
  pose.a =
      std::hypot(n.y(), n.z()) > 1e-9 ? wrap_to(std::atan2(-n.y(), n.z()), before.a) : before.a;
  const Mat3 head = rotate(pose.a, Vec3::UnitX()) * rotate(pose.b, Vec3::UnitY());
  pose.xyz = tip.position + head * machine.pivot - machine.pivot;
  return pose;
}

struct Axis {
  const char* name;
  const AxisLimit* limit;
  double from, to;
};

std::array<Axis, 6> axes_of(const MachineProfile& m, const MachinePose& from,
                            const MachinePose& to) {
  return {{{"X", &m.x, from.xyz.x(), to.xyz.x()},
           {"Y", &m.y, from.xyz.y(), to.xyz.y()},
           {"Z", &m.z, from.xyz.z(), to.xyz.z()},
           {"A", &m.a, from.a, to.a},
           {"B", &m.b, from.b, to.b},
           {"C", &m.c, from.c, to.c}}};
}

Vec3 center_offset(const Waypoints& waypoints) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(kInfinity, kInfinity), high(-kInfinity, -kInfinity);
  for (Index i = 0; i < waypoints.size(); ++i) {
    if (waypoints.travel[static_cast<std::size_t>(i)]) continue;
    const Eigen::Vector2d p = waypoints.position.row(i).head<2>();
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (!(low.x() <= high.x())) return Vec3::Zero();
  return Vec3(-0.5 * (low.x() + high.x()), -0.5 * (low.y() + high.y()), 0);
}

class Planner {
 public:
  Planner(const Waypoints& waypoints, const MachineProfile& machine)
      : waypoints_(waypoints), machine_(machine) {
    motion_.part_offset = center_offset(waypoints);
  }

  MachineMotion plan(Context& ctx) {
    for (Index i = 0; i < waypoints_.size(); ++i) {
      if (i % 4096 == 0) ctx.checkpoint();
      add(i);
    }
    const auto n = static_cast<Eigen::Index>(duration_.size());
    motion_.duration = Eigen::Map<const Values>(duration_.data(), n);
    motion_.extrusion = Eigen::Map<const Values>(extrusion_.data(), n);
    report(ctx);
    return std::move(motion_);
  }

 private:
  TipPose tip(Index i) const {
    return {Vec3(waypoints_.position.row(i)) + motion_.part_offset, waypoints_.normal.row(i)};
  }

  void add(Index i) {
    const TipPose to = tip(i);
    if (i == 0) {
      record(inverse_kinematics(machine_, to, {}), i, 0, 0, true);
      return;
    }
    const TipPose from = tip(i - 1);
    const MachinePose start = motion_.pose.back();
    const MachinePose end = inverse_kinematics(machine_, to, start);
    const double turn =
        std::max({std::abs(end.a - start.a), std::abs(end.b - start.b), std::abs(end.c - start.c)});
    const int steps = std::max(1, static_cast<int>(std::ceil(turn / kRotaryStep - 1e-9)));
    const double length = (to.position - from.position).norm();
    const double speed = waypoints_.speed(i);
    for (int k = 1; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      MachinePose pose = end;
      if (k < steps) {
        // The rotary axes run evenly; X Y Z follow so that the tip stays on the straight line.
        pose.a = start.a + t * (end.a - start.a);
        pose.b = start.b + t * (end.b - start.b);
        pose.c = start.c + t * (end.c - start.c);
        pose.xyz = place_tip(from.position + t * (to.position - from.position), pose);
      }
      record(pose, i, speed > 0 ? length / steps / speed : 0, waypoints_.extrusion(i) / steps,
             k == steps);
    }
  }

  /// X Y Z that hold the tip at p with the given rotary axes.
  Vec3 place_tip(const Vec3& p, const MachinePose& pose) const {
    switch (machine_.kinematics) {
      case Kinematics::cartesian:
        return p;
      case Kinematics::table_bc:
        return rotate(pose.b, Vec3::UnitY()) *
                   (rotate(pose.c, Vec3::UnitZ()) * p - machine_.pivot) +
               machine_.pivot;
      case Kinematics::head_ab:
        return p + rotate(pose.a, Vec3::UnitX()) * rotate(pose.b, Vec3::UnitY()) * machine_.pivot -
               machine_.pivot;
    }
    return p;
  }

  void record(const MachinePose& pose, Index waypoint, double duration, double extrusion,
              bool arrives) {
    const MachinePose& before = motion_.pose.empty() ? pose : motion_.pose.back();
    for (const Axis& axis : axes_of(machine_, before, pose)) {
      if (axis.limit->speed > 0)
        duration = std::max(duration, std::abs(axis.to - axis.from) / axis.limit->speed);
      if (axis.limit->min == axis.limit->max || within(*axis.limit, axis.to)) continue;
      if (outside_.empty() || outside_.back() != waypoint) outside_.push_back(waypoint);
      const double excess = std::max(axis.limit->min - axis.to, axis.to - axis.limit->max);
      const bool rotary = *axis.name < 'X';
      if (worst_axis_.empty() || excess > worst_excess_)
        worst_excess_ = excess, worst_axis_ = axis.name, worst_waypoint_ = waypoint,
        worst_rotary_ = rotary;
    }
    motion_.pose.push_back(pose);
    duration_.push_back(duration);
    extrusion_.push_back(extrusion);
    motion_.waypoint.push_back(waypoint);
    motion_.arrives.push_back(arrives ? 1 : 0);
  }

  void report(Context& ctx) const {
    if (outside_.empty()) return;
    std::vector<Vec3> places;
    constexpr std::size_t kMostPlaces = 100;
    for (std::size_t i = 0; i < std::min(outside_.size(), kMostPlaces); ++i)
      places.push_back(waypoints_.position.row(outside_[i]));
    const double excess = worst_rotary_ ? degrees(worst_excess_) : worst_excess_;
    std::string amount = std::to_string(excess);
    amount.resize(amount.find('.') + 2);
    ctx.warn(
        "motion.axis_limit",
        std::to_string(outside_.size()) + " of " + std::to_string(waypoints_.size()) +
            " waypoints are out of reach of " + machine_.name + ", the first is number " +
            std::to_string(outside_.front()) + "; worst is axis " + worst_axis_ + " at waypoint " +
            std::to_string(worst_waypoint_) + ", " + amount + (worst_rotary_ ? "°" : " mm") +
            " beyond its range. Lower deform.max_tilt, scale the part or choose another machine.",
        places);
  }

  const Waypoints& waypoints_;
  const MachineProfile& machine_;
  MachineMotion motion_;
  std::vector<double> duration_, extrusion_;
  std::vector<Index> outside_;
  double worst_excess_ = 0;
  std::string worst_axis_;
  Index worst_waypoint_ = 0;
  bool worst_rotary_ = false;
};

}  // namespace

TipPose forward_kinematics(const MachineProfile& machine, const MachinePose& pose) {
  switch (machine.kinematics) {
    case Kinematics::cartesian:
      return {pose.xyz, Vec3::UnitZ()};
    case Kinematics::table_bc: {
      const Mat3 tilt = rotate(-pose.b, Vec3::UnitY()), turn = rotate(-pose.c, Vec3::UnitZ());
      return {turn * (tilt * (pose.xyz - machine.pivot) + machine.pivot),
              turn * tilt * Vec3::UnitZ()};
    }
    case Kinematics::head_ab: {
      const Mat3 head = rotate(pose.a, Vec3::UnitX()) * rotate(pose.b, Vec3::UnitY());
      return {pose.xyz + machine.pivot - head * machine.pivot, head * Vec3::UnitZ()};
    }
  }
  return {pose.xyz, Vec3::UnitZ()};
}

MachinePose inverse_kinematics(const MachineProfile& machine, const TipPose& tip,
                               const MachinePose& before) {
  switch (machine.kinematics) {
    case Kinematics::cartesian:
      break;
    case Kinematics::table_bc:
      return inverse_table(machine, tip, before);
    case Kinematics::head_ab:
      return inverse_head(machine, tip, before);
  }
  MachinePose pose;
  pose.xyz = tip.position;
  return pose;
}

MachineMotion plan_motion(const Waypoints& waypoints, const MachineProfile& machine, Context& ctx) {
  return Planner(waypoints, machine).plan(ctx);
}

}  // namespace s3
