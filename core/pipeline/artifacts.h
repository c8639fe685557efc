// Every stage's result.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "export/fields_vtu.h"
#include "fea/stress.h"
#include "layers/layer.h"
#include "mesh/orientation.h"
#include "mesh/tet_mesh.h"
#include "mesh/tri_mesh.h"
#include "metrics/histograms.h"
#include "metrics/metrics.h"
#include "motion/five_axis.h"
#include "objectives/objectives.h"
#include "outer_loop/deformer.h"
#include "toolpaths/toolpaths.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// What the model file was.
struct ModelInfo {
  std::string format;
  bool is_volume = false;
  Index triangles = 0;  // of the surface as the file gives it (of a volume: its boundary)
  double volume = 0;    // mm³
  std::vector<std::string> repairs;
  std::vector<Orientation> orientations;  // of a search, best first; the first was taken
};

/// What is printed, from the field's layers to the machine.
struct Print {
  LayerStack layers;
  Toolpaths toolpaths;
  Waypoints waypoints;
};

struct NamedFile {
  std::string name;
  std::string content;
};

struct Artifacts {
  ModelInfo model;                                          // mesh
  Eigen::Affine3d placement = Eigen::Affine3d::Identity();  // mesh: file frame → rest frame
  TriMesh
      surface;   // mesh: the model's surface, placed on the plate; evaluation measures against it
  TetMesh rest;  // mesh for volume files, tetrahedralize for surfaces
  FileOrder file_order;                    // rows of a volume file in `rest`; empty for surfaces
  std::optional<StressField> stress;       // fea
  ObjectiveField objectives;               // objectives
  DeformResult deformation;                // outer_loop
  Print curved;                            // layers, toolpaths, waypoints
  MachineMotion motion;                    // motion
  std::vector<NamedFile> programs;         // exporting
  Print planar;                            // metrics: the baseline
  Metrics curved_metrics, planar_metrics;  // metrics
  std::vector<SvgFile> plots;              // metrics
};

}  // namespace s3
