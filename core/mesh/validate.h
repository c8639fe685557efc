// Is this surface the border of a solid? Counts, shells and an exact self-intersection test (Sec.
// 2).
#pragma once
#include <array>
#include <string>
#include <vector>

#include "base/context.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// How often something is wrong, and where, mm (the first hundred places).
struct Defect {
  Index count = 0;
  std::vector<Vec3> where;

  void add(const Vec3& place);
};

/// A part of the surface that hangs together by edges.
struct Shell {
  Index triangles = 0;
  double volume = 0;  // signed, mm³; means something on a closed shell only
  Index depth =
      0;  // number of other shells around it: even for a body, odd for a cavity; closed shells only
  bool inverted = false;  // faces inward where it should face outward, or the other way round
  Vec3 place = Vec3::Zero();
};

struct MeshReport {
  Index vertices = 0, triangles = 0;
  Box box;
  double area = 0, volume = 0;  // mm², mm³
  Index unused_vertices = 0;
  Defect degenerate_triangles;  // exactly without area
  Defect duplicate_triangles;   // the same three corners as an earlier one
  Defect open_edges;            // one triangle
  Defect nonmanifold_edges;     // more than two triangles
  Defect inconsistent_edges;    // two triangles that run along it in the same direction
  Defect nonmanifold_vertices;  // more than one fan of triangles
  Defect self_intersections;    // pairs of triangles; at most kMaxIntersections are counted
  std::vector<std::array<Index, 2>> intersecting_pairs;
  std::vector<Shell> shells;  // largest |volume| first

  static constexpr Index kMaxIntersections = 10000;

  bool closed() const { return triangles > 0 && open_edges.count == 0; }
  Index inverted_shells() const;
  /// The border of a solid that can be meshed.
  bool valid() const;
};

/// Looks at everything; changes nothing. Near-linear time. Triangles without area are left out of
/// the intersection test.
/// @param mesh  indices in range (as from read_model)
/// @param ctx   may be null; asked for a cancel on the way
MeshReport inspect_surface(const TriMesh& mesh, const Context* ctx = nullptr);

/// The shells of a surface: which triangle belongs to which, and what each is.
struct Shells {
  std::vector<Index> of_triangle;  // #F
  std::vector<Shell> shells;       // in the order of their first triangles
};
/// Depth and inversion are known where all shells are closed and oriented.
Shells measure_shells(const TriMesh& mesh);

/// @throws Error "mesh.empty", "mesh.open_boundary", "mesh.non_manifold",
/// "mesh.inconsistent_orientation",
///         "mesh.degenerate", "mesh.duplicate_triangles", "mesh.self_intersection",
///         "mesh.inverted": the first that holds, with numbers and places
void require_valid_surface(const MeshReport& report);

/// Mends what can be mended without changing the shape: drops triangles with a repeated corner and
/// unused vertices, joins vertices of equal coordinates where that closes the surface, turns shells
/// that are inside out.
/// @return a sentence for each, for the user
std::vector<std::string> clean_surface(TriMesh& mesh);

/// Warns ("mesh.units") when a model in mm would be smaller than 1 mm or larger than 2 m.
void warn_about_units(const Box& box, Context& ctx);

}  // namespace s3
