// The figures that a run is judged by (Sec. 5.2), for its curved layers and for planar layers of
// the same mesh.
#pragma once
#include <optional>

namespace s3 {

/// Distance from layers to the material below, weighted by area, mm.
struct ThicknessFigures {
  double min = 0, p1 = 0, p50 = 0, p99 = 0, max = 0;
};

/// The largest principal strain of the printed part under its load cases, weighted by volume
/// (metrics/strain.h).
struct StrainFigures {
  double max = 0, p999 = 0, mean = 0;
};

/// Lines of hybrid toolpaths against the projected τ_max within S, weighted by area, degrees.
struct DeviationFigures {
  double p50 = 0, p90 = 0, p99 = 0;
};

/// Distance between neighbouring strands where lines fill a layer, weighted by area, in bead
/// widths.
struct SpacingFigures {
  double p5 = 0, p50 = 0, p95 = 0;
  double within_15_percent = 0;  // % of the area between 0.85 and 1.15
};

/// What was not computed is empty, never 0. Areas leave out the faces on the plate (plate_faces()
/// of mesh/tet_mesh.h).
struct Metrics {
  // The print directions on the mesh (lpd_metrics.h).
  std::optional<double>
      support_free_area_percent;  // faces that overhang their layer by at most 45°
  std::optional<double>
      support_free_mean_violation_deg;  // by how much faces overhang beyond 45°: mean over the area
  std::optional<double> surface_quality_area_percent;  // |n·d| ≤ sin 10°, or at most 10° to ±n
  std::optional<double>
      surface_quality_region_percent;  // the same of the faces in objectives.surface_region
  std::optional<double>
      strength_critical_percent;     // critical tets with τ_max within 10° of the layer
  std::optional<double> pi_rad;      // Eq. 13 as a mean angle over S ∪ B
  std::optional<int> foldovers;      // tets of M^d with a volume ≤ 0
  std::optional<int> gouging_pairs;  // neighbours that are concave beyond the head's clearance
  std::optional<int> concave_pairs_over_20deg;
  std::optional<int> islands;  // places where material would start in the air

  // The layers.
  std::optional<int> layers, components;
  std::optional<ThicknessFigures> thickness_mm;
  std::optional<double> thickness_outside_area_percent;  // outside [d_min, d_max]

  // The toolpaths (print_metrics.h).
  std::optional<double> path_length_mm, coverage_percent, overlap_percent;
  std::optional<DeviationFigures> stress_deviation_deg;
  std::optional<SpacingFigures> line_spacing;
  std::optional<double> surface_error_avg_mm, surface_error_max_mm;  // Sec. 5.2.1
  std::optional<StrainFigures> strain;  // Sec. 5.2.3; empty without a load case
  std::optional<double> support_volume_mm3, material_g, print_time_s;
};

}  // namespace s3
