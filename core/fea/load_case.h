// Load cases: what holds a part and what loads it, as a JSON file (Sec. 2.1.2).
//
// {
//   "material": "PLA",
//   "regions": { "ears": {"half_space": {"point": [0, 0, 95], "normal": [0, 0, 1]}} },
//   "conditions": [ {"region": "plate", "fixed": true} ],
//   "cases": [
//     {"name": "pressed", "conditions": [{"region": "ears", "force": [0, 0, -100]}]},
//     {"name": "own weight", "conditions": [{"gravity": [0, 0, -9.81]}]}
//   ]
// }
//
// * All coordinates are those of the part as it stands on the plate: mm, z up, plate at z = 0,
//   after input.up, input.scale and input.rotate.
// * `material`: a bundled name, or {"young": MPa, "poisson": ν, "density": g/cm³, "printed":
//   {"young": [Y1, Y2, Y3], "poisson": [ν12, ν13, ν23], "shear": [G12, G13, G23]}}; `printed` are
//   the constants along and across the bead for the verification, and without it the paper's
//   ratio Y2 / Y1 = Y3 / Y1 = 1.2 / 3.5 is taken. PLA where nothing is said.
// * A region is a set of faces of the part's surface. `"plate"` is the contact with the plate,
//   other texts are names under `regions`, a list is the union of its members, the rest objects:
//     {"plane": {"point", "normal", "tolerance"}}
//         faces that lie on the plane and face along the normal; within the tolerance in mm, 0.1 %
//         of the part's diagonal if not given
//     {"half_space": {"point", "normal"}}
//         faces with their centroid on the normal's side
//     {"box": {"min", "max"}}, {"sphere": {"center", "radius"}}
//         faces with their centroid inside
//     {"faces": {"points", "angle"}}
//         the faces nearest to the points; with an angle in degrees also all that hang together
//         with such a face and are turned against it by no more than that
// * A condition has a region and one of
//     "fixed": true or axes such as "z" or "xy"   no displacement
//     "displacement": [0, null, -0.5]             mm; null leaves the axis free
//     "force": [x, y, z]                          N in total, spread evenly over the area
//     "pressure": p                               MPa, against the surface
//   or it is {"gravity": [x, y, z]} in m/s², on the whole part.
// * `conditions` at the top hold in every case. Without `cases` they are the only one.
// * `about` may hold any text.
//
// A region file (objectives.surface_region, strength.critical_region) has regions alone:
//
// { "region": ["ears", {"box": {"min": [0, 0, 0], "max": [9, 9, 40]}}],
//   "regions": { "ears": {"half_space": {"point": [0, 0, 95], "normal": [0, 0, 1]}} } }
#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/stage.h"
#include "base/types.h"
#include "fea/material.h"

namespace s3 {

struct PlateContact {};
struct PlaneContact {
  Vec3 point, normal;               // unit
  std::optional<double> tolerance;  // mm
};
struct HalfSpace {
  Vec3 point, normal;  // unit
};
struct BoxRegion {
  Vec3 low, high;
};
struct SphereRegion {
  Vec3 center;
  double radius;
};
struct PickedFaces {
  std::shared_ptr<const std::vector<Vec3>> points;  // shared by the unions that name the region
  double angle;                                     // rad
};
using Shape =
    std::variant<PlateContact, PlaneContact, HalfSpace, BoxRegion, SphereRegion, PickedFaces>;

/// The union of some shapes, with the name that messages call it by.
struct Region {
  std::string name;
  std::vector<Shape> shapes;
};

struct Displacement {
  std::array<std::optional<double>, 3> value;  // mm; nothing on a free axis
};
struct TotalForce {
  Vec3 newton;
};
struct Pressure {
  double megapascal;
};
struct Gravity {
  Vec3 acceleration;  // m/s²
};
using Action = std::variant<Displacement, TotalForce, Pressure, Gravity>;

struct Condition {
  std::size_t region;  // in LoadCases::regions; not read for gravity
  Action action;
};

struct LoadCase {
  std::string name;
  std::vector<Condition> conditions;
};

struct LoadCases {
  Material material;
  std::vector<Region> regions;
  std::vector<LoadCase> cases;  // at least one
};

/// Reads the JSON form.
/// @throws Error "fea.bad_load_case" with the place in the file: unknown keys, numbers that are
/// none, missing parts; "fea.bad_material"
LoadCases read_load_cases(std::span<const std::byte> bytes, std::string_view file_name);

/// Reads a region file, for a stage that uses the faces or tets of it.
/// @throws Error "<stage>.bad_region" with the place in the file
Region read_region_file(std::span<const std::byte> bytes, std::string_view file_name, Stage stage);

}  // namespace s3
