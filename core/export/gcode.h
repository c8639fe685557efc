// program.gcode: a machine's motion in RepRapFirmware's dialect.
//
// Absolute axes (G90) in mm and degrees, relative extruder (M83). Moves in which a rotary axis
// turns run under G93: F is the inverse of the move's duration in 1/min and stands on every such
// move, since a feed rate in mm/min would mean the length of X Y Z and not the way of the tip over
// the part. Other moves run under G94 with F in mm/min. The header comment states frames, axis
// signs, pivot and the offset of the part.
#pragma once
#include <string>

#include "base/context.h"
#include "motion/five_axis.h"
#include "motion/machine_profile.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// @param motion  of these waypoints on this machine (plan_motion)
std::string write_gcode(const Waypoints& waypoints, const MachineMotion& motion,
                        const MachineProfile& machine, Context& ctx);

}  // namespace s3
