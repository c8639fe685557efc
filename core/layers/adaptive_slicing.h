// Curved layers of bounded thickness (Sec. 4.2): isosurfaces of G, spaced by exact
// surface-to-surface distances, cut where they would be too thin.
#pragma once
#include <vector>

#include "base/context.h"
#include "layers/layer.h"
#include "mesh/tet_mesh.h"
#include "params/param_info.h"
#include "scalar_field/scalar_field.h"

namespace s3 {

struct LayerParams {
  double nozzle_diameter = 1.0;  // D, mm
  double min_thickness = 0;      // d_min, mm; 0 = 0.4·D
  double max_thickness = 0;      // d_max, mm; 0 = 1.0·D

  double d_min() const { return min_thickness > 0 ? min_thickness : 0.4 * nozzle_diameter; }
  double d_max() const { return max_thickness > 0 ? max_thickness : 1.0 * nozzle_diameter; }
};

template <class Visitor>
void describe(Visitor& v, LayerParams& p) {
  const auto length = [&](double& field, std::string_view key, std::string_view label, double min,
                          std::string_view doc) {
    v(field, ParamInfo{.key = key,
                       .label = label,
                       .unit = "mm",
                       .doc = doc,
                       .min = min,
                       .max = 1000,
                       .stage = Stage::layers});
  };
  length(p.nozzle_diameter, "nozzle.diameter", "Nozzle diameter", 0.01,
         "Diameter D of the nozzle's opening.");
  length(p.min_thickness, "layers.min_thickness", "Thinnest layer", 0,
         "No layer is thinner than this anywhere; 0 stands for 0.4 times the nozzle diameter.");
  length(p.max_thickness, "layers.max_thickness", "Thickest layer", 0,
         "No layer is thicker than this anywhere; 0 stands for the nozzle diameter.");
}

/// Slices the part along its field.
///
/// The part stands on the plate z = 0. Every point of every layer is at least d_min and at most
/// d_max away from the earlier layers or the plate; what cannot be within d_max of anything below
/// (material that starts in the air) is reported in the stack and as warning "layers.unsupported".
/// @throws Error "layers.bad_range" for a thickness range that is empty or too narrow,
/// "layers.empty" when no layer fits
LayerStack make_layers(const TetMesh& rest, const ScalarField& field, const LayerParams& params,
                       Context& ctx);

/// The baseline of the paper's comparison (Sec. 5.3): horizontal layers of one height.
/// @param layer_height  mm
LayerStack make_planar_layers(const TetMesh& rest, double layer_height, const LayerParams& params,
                              Context& ctx);

}  // namespace s3
