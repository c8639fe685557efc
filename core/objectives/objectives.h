// The objectives of a run as data on the mesh (Sec. 2.1): which faces and tets ask for what.
#pragma once
#include <string>
#include <vector>

#include "base/types.h"
#include "fea/stress.h"
#include "mesh/tet_mesh.h"
#include "params/param_info.h"

namespace s3 {

struct ObjectiveParams {
  double support_free = 1.0;     // w_SF in [0, 1]; 0 switches the objective off
  double strength = 0.0;         // w_SR
  double surface_quality = 0.0;  // w_SQ
  double alpha_deg = 45;         // self-supporting angle α, Eq. 1
  double beta_deg = 10;          // tolerance β, Eq. 2
  double gamma_deg = 20;         // cliff angle γ, Eq. 4
  std::string surface_region;    // region file of the faces that SQ is for; empty for all
};

template <class Visitor>
void describe(Visitor& v, ObjectiveParams& p) {
  const auto weight = [&](double& field, std::string_view key, std::string_view label,
                          std::string_view doc) {
    v(field, ParamInfo{.key = key,
                       .label = label,
                       .unit = "",
                       .doc = doc,
                       .min = 0,
                       .max = 1,
                       .stage = Stage::objectives});
  };
  weight(p.support_free, "objectives.support_free", "Support free",
         "Weight w_SF: no face may overhang its layer by more than alpha; 0 switches it off.");
  weight(p.strength, "objectives.strength", "Strength",
         "Weight w_SR: layers run along the largest tension; 0 switches it off.");
  weight(p.surface_quality, "objectives.surface_quality", "Surface quality",
         "Weight w_SQ: layers meet the surface flat or upright, without stair-steps; 0 switches it "
         "off.");
  const auto angle = [&](double& field, std::string_view key, std::string_view label,
                         std::string_view doc) {
    v(field, ParamInfo{.key = key,
                       .label = label,
                       .unit = "deg",
                       .doc = doc,
                       .min = 0,
                       .max = 90,
                       .stage = Stage::objectives});
  };
  angle(p.alpha_deg, "objectives.alpha", "Self-supporting angle",
        "Angle alpha of Eq. 1: how far a face may overhang its layer and still print.");
  angle(p.beta_deg, "objectives.beta", "Strength tolerance",
        "Angle beta of Eq. 2: how far a layer may deviate from the largest tension.");
  angle(p.gamma_deg, "objectives.gamma", "Cliff angle",
        "Angle gamma of Eq. 4: how far a face may lean against its layers' normal and still look "
        "smooth.");
  v(p.surface_region,
    ParamInfo{.key = "objectives.surface_region",
              .label = "Surface region",
              .unit = "",
              .doc = "JSON file of the region whose faces surface quality is for, in the frame of "
                     "the part on its plate; empty for the whole surface.",
              .stage = Stage::objectives});
}

/// Everything that objectives, weights and metrics ask of a mesh; built once for each mesh and job.
struct ObjectiveField {
  Directions face_normal;         // #B×3: outward unit normals of the boundary faces, rest frame
  Values face_area;               // #B mm²
  std::vector<char> face_exempt;  // #B: 1 on plate contact: no SF, no SQ
  std::vector<char> face_wants_quality;  // #B: 1 where SQ applies
  std::vector<char> face_in_region;      // #B: 1 in the region for SQ; empty without one
  std::vector<Index> boundary_tets;      // B: ascending, unique
  std::vector<Index> tet_face_begin;     // #T+1: offsets into tet_faces
  std::vector<Index> tet_faces;          // boundary faces grouped by tet
  std::vector<char> critical;            // #T: 1 in S; empty without SR
  Directions tau_max;                    // #T×3; empty without SR
  Values tension;                        // #T MPa, along tau_max; empty without SR
  std::vector<char> vertex_on_plate;     // #V: vertices of the plate contact, where G = 0
};

/// @param stress          may be null where the strength weight is 0
/// @param surface_region  the faces that SQ is for; null for all
/// @throws Error "objectives.empty_region"
ObjectiveField make_objectives(const TetMesh& rest, const ObjectiveParams& params,
                               const StressField* stress, const Region* surface_region = nullptr);

}  // namespace s3
