// Every stage's result.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "export/fields_vtu.h"
#include "fea/load_case.h"
#include "fea/stress.h"
#include "layers/layer.h"
#include "mesh/orientation.h"
#include "mesh/repair.h"
#include "mesh/surface_distance.h"
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
  Index triangles = 0;           // of the surface as the file gives it (of a volume: its boundary)
  std::optional<double> volume;  // mm³, of what is printed; not known before a rebuild
  std::vector<RepairChange> repairs;
  std::vector<Orientation> orientations;  // of a search, best first; the first was taken
  std::string defect;  // why the repaired surface is no border of a solid; empty when it is one
};

/// How the surface became tets.
struct Filling {
  std::string backend;       // of mesh.backend, the one that did it; "file" for a volume
  std::string fallback;      // why it was not the first choice; empty when it was
  bool rebuilt = false;      // the tets' boundary only approximates the surface
  SurfaceDistance distance;  // of the tets' boundary to the repaired surface, when rebuilt
  double diagonal = 0;       // mm, of the model's box
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
  TriMesh given;    // mesh: a file's surface, repaired and placed on the plate; empty for a volume
  Filling filling;  // mesh for volume files, tetrahedralize for surfaces
  /// mesh, and tetrahedralize where the solid was rebuilt: what evaluation measures against.
  TriMesh surface;
  TetMesh rest;                            // mesh for volume files, tetrahedralize for surfaces
  FileOrder file_order;                    // rows of a volume file in `rest`; empty for surfaces
  std::optional<LoadCases> load_cases;     // fea: of strength.load_case
  std::optional<StressField> stress;       // fea: in the rest frame
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
