// Waypoints as axis positions of machines with at most two rotary axes.
//
// Frames: the plate frame P is the part's, z up, its origin where the table's C axis meets the
// plate; the part is moved in x and y so that the middle of its bounding box stands there. The
// machine frame M is fixed in space and coincides with P when all rotary axes are 0. All angles
// follow the right-hand rule about the positive axis.
//
// * table_bc: the table turns about C (z of the table), and the turning table tilts about B (y of
// the machine) around the
//   pivot. A point p of the part is found at  q = R_y(B) (R_z(C) p − pivot) + pivot,  and its
//   normal n must be R_y(B) R_z(C) n = z. X Y Z is where the tip stands in M: X Y Z = q.
// * head_ab: the head tilts about A (x), and what A carries about B (y); the nozzle's axis, from
// the tip upwards, is
//   R_x(A) R_y(B) z = n. X Y Z is the tip plus what the pivot has moved: p + (R_x(A) R_y(B) − 1) ·
//   (tip → pivot), so that a controller without tool-centre-point control can run it.
// * cartesian: X Y Z = p, the normal has no influence.
#pragma once
#include <vector>

#include "base/context.h"
#include "base/units.h"
#include "motion/machine_profile.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// Axis positions: mm; rad. Axes that a machine does not have stay 0.
struct MachinePose {
  Vec3 xyz = Vec3::Zero();
  double a = 0, b = 0, c = 0;
};

struct TipPose {
  Vec3 position, normal;  // plate frame
};

/// Where the tip stands on the part, and along which direction.
TipPose forward_kinematics(const MachineProfile& machine, const MachinePose& pose);

/// How far the nozzle may lean from the normal to spare the rotary axes.
constexpr double kNormalTolerance = radians(0.5);

/// Axis positions for one tip pose, near the pose before.
///
/// A direction close to z leaves C (head_ab: nothing) undecided: the nozzle may lean up to
/// kNormalTolerance from the normal, and within that C moves as little as possible. Of the two ways
/// to reach a direction (B and C, or −B and C + π), and of all full turns, the one nearest to
/// `before` within the limits is taken: C is unwrapped and never takes the short way round.
MachinePose inverse_kinematics(const MachineProfile& machine, const TipPose& tip,
                               const MachinePose& before);

/// What a controller executes: moves on straight lines in the space of axes.
struct MachineMotion {
  Vec3 part_offset = Vec3::Zero();  // mm, added to the waypoints' positions
  std::vector<MachinePose> pose;    // #M: at the end of each move
  Values duration;                  // #M s
  Values extrusion;                 // #M mm of filament
  std::vector<Index> waypoint;      // #M: the waypoint that the move leads to, or towards
  std::vector<char>
      arrives;  // #M: 1 where the move ends at that waypoint, 0 on intermediate points
};

/// Moves for all waypoints. Where the rotary axes turn by more than 3° between two waypoints,
/// intermediate points keep the tip on its straight line. Each move lasts as long as its tip speed,
/// or its slowest axis, demands. Warns "motion.axis_limit" with the waypoints that are out of an
/// axis' range.
MachineMotion plan_motion(const Waypoints& waypoints, const MachineProfile& machine, Context& ctx);

}  // namespace s3
