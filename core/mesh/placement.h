// Setup orientation: how the model's file frame becomes the printer's frame, z up, plate at z = 0
// (Sec. 5.4.4).
#pragma once
#include <string>
#include <vector>

#include "base/context.h"
#include "base/types.h"
#include "mesh/orientation.h"
#include "params/param_info.h"

namespace s3 {

struct InputParams {
  std::string up = "z";          // the file's up axis
  double scale = 1;              // file units to mm
  std::string rotate = "0,0,0";  // Euler degrees "x,y,z", "flat" or "auto"
  double sheet_thickness = 0;    // mm, given to surfaces that enclose nothing; 0: they are refused
};

template <class Visitor>
void describe(Visitor& v, InputParams& p) {
  v(p.up, ParamInfo{.key = "input.up",
                    .label = "Up axis",
                    .unit = "",
                    .doc = "The up axis of the model file.",
                    .choices = {"z", "y"},
                    .stage = Stage::mesh});
  v(p.scale, ParamInfo{.key = "input.scale",
                       .label = "Scale",
                       .unit = "",
                       .doc = "Factor from the file's unit to millimetres.",
                       .min = 1e-6,
                       .max = 1e6,
                       .stage = Stage::mesh});
  v(p.rotate, ParamInfo{.key = "input.rotate",
                        .label = "Rotation",
                        .unit = "deg",
                        .doc = "Turns by x, then y, then z about the fixed axes (\"90,0,45\"), "
                               "\"flat\" to lay the largest flat face down, or \"auto\" for the "
                               "least overhang and support.",
                        .stage = Stage::mesh});
  v(p.sheet_thickness, ParamInfo{.key = "input.sheet_thickness",
                                 .label = "Sheet thickness",
                                 .unit = "mm",
                                 .doc = "Thickness given to an open surface that encloses nothing; "
                                        "0 refuses it.",
                                 .min = 0,
                                 .max = 1000,
                                 .stage = Stage::mesh});
}

/// From the file's frame (mm after scaling) to the printer's: up axis, scale, rotation, then a
/// shift along z that puts the lowest vertex at z = 0. x and y are not shifted, so that fields stay
/// comparable with the input. Directions turn with `.rotation()`.
/// @param vertices      #V×3, not empty
/// @param surface       #F×3 outward triangles into vertices; read for "flat" and "auto" only
/// @param orientations  may be null; gets what rank_orientations() found for "flat" and "auto"
///                      (the first was taken), nothing otherwise
/// @param ctx           may be null; asked for a cancel on the way
/// @throws Error "mesh.bad_placement" for parameters that mean nothing, "mesh.no_flat_face"
Eigen::Affine3d placement(const Points& vertices, const Triangles& surface,
                          const InputParams& params,
                          std::vector<Orientation>* orientations = nullptr,
                          const Context* ctx = nullptr);

/// Moves all points.
void transform_points(const Eigen::Affine3d& transform, Points& points);

}  // namespace s3
