// Stress from a file (Sec. 2.1.2).
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fea/stress.h"
#include "params/param_info.h"

namespace s3 {

struct StrengthParams {
  std::string stress_file;      // empty for none
  std::string load_case;        // empty for none
  double critical_ratio = 0.3;  // share of the tets in S
  std::string critical_region;  // region file of tets that S takes in any case; empty for none
  int smoothing = 0;            // passes of smooth_stress()
};

template <class Visitor>
void describe(Visitor& v, StrengthParams& p) {
  v(p.stress_file,
    ParamInfo{
        .key = "strength.stress_file",
        .label = "Stress file",
        .unit = "",
        .doc =
            "Stress of every tet, as CSV (tensor or principal direction) or VTU cell data, in the "
            "frame of the mesh file.",
        .stage = Stage::fea});
  v(p.load_case, ParamInfo{.key = "strength.load_case",
                           .label = "Load case",
                           .unit = "",
                           .doc = "JSON file that says what is fixed and what is loaded, in the "
                                  "frame of the part on its plate, for the built-in analysis.",
                           .stage = Stage::fea});
  v(p.critical_ratio,
    ParamInfo{.key = "strength.critical_ratio",
              .label = "Critical ratio",
              .unit = "",
              .doc = "Share of all tets, those of the largest tension, that are critical.",
              .min = 0,
              .max = 1,
              .stage = Stage::fea});
  v(p.critical_region,
    ParamInfo{.key = "strength.critical_region",
              .label = "Critical region",
              .unit = "",
              .doc = "JSON file of a region whose tets are critical beside those of the largest "
                     "tension, in the frame of the part on its plate.",
              .stage = Stage::fea});
  v(p.smoothing,
    ParamInfo{.key = "strength.smoothing",
              .label = "Smoothing of the stress",
              .unit = "",
              .doc = "How often the stress of a tet is replaced by the mean of its vertices' tets; "
                     "0 takes the stress as it is computed.",
              .min = 0,
              .max = 20,
              .stage = Stage::fea,
              .advanced = true});
}

/// Reads stress from CSV text or a VTU file. Columns may be separated by commas, semicolons or
/// blanks; one header line is allowed.
///
/// Eight columns `index,maxPrincipal,S11,S22,S33,S12,S13,S23`: 1-based tet indices in any order;
/// principal value and direction come from the tensor. Five columns `principal x y z line-id`, one
/// row a tet in order: the direction is normalised. The frame is that of the file: see
/// rotate_stress().
/// @param critical_ratio  see critical_tets()
/// @throws Error "fea.bad_stress_file" with the line, "fea.stress_count" when the rows are not #T,
/// "mesh.bad_file" for a
///         damaged VTU file
StressField read_stress(std::span<const std::byte> bytes, std::string_view file_name,
                        Index tet_count, double critical_ratio);

}  // namespace s3
