// Every parameter of a run: each stage's own struct, one after the other.
#pragma once
#include <string>

#include "fea/read_stress.h"
#include "layers/adaptive_slicing.h"
#include "mesh/placement.h"
#include "motion/machine_profile.h"
#include "objectives/objectives.h"
#include "outer_loop/deformer.h"
#include "params/param_info.h"
#include "tetrahedralize/tetrahedralize.h"
#include "toolpaths/make_toolpaths.h"

namespace s3 {

struct Params {
  Params() { deform.max_tilt_deg = 0; }  // the machine's

  std::string model;  // path of the model file: for the program that reads it, not for the core
  InputParams input;
  TetrahedralizeParams mesh;
  StrengthParams strength;
  ObjectiveParams objectives;
  DeformParams deform;
  LayerParams layers;
  ToolpathParams toolpath;
  MachineParams machine;
};

template <class Visitor>
void describe(Visitor& v, Params& p) {
  v(p.model, ParamInfo{.key = "model",
                       .label = "Model",
                       .unit = "",
                       .doc = "Path of the model file; the command line's MODEL overrides it.",
                       .stage = Stage::mesh});
  describe(v, p.input);
  describe(v, p.mesh);
  describe(v, p.strength);
  describe(v, p.objectives);
  describe(v, p.deform);
  describe(v, p.layers);
  describe(v, p.toolpath);
  describe(v, p.machine);
}

/// The parameters with every 0 that stands for "derived" replaced by its value: deform.max_tilt
/// from the machine, layer thickness and bead width from the nozzle.
/// @throws Error "params.out_of_range" where values contradict each other
Params resolve(const Params& params, const MachineProfile& machine);

}  // namespace s3
