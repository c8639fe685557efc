// How far two surfaces are apart, measured at even samples in both directions.
#pragma once
#include "base/context.h"
#include "mesh/tri_mesh.h"
#include "mesh/winding_number.h"

namespace s3 {

/// Distances, mm, of even samples of one surface to the closest points of the other.
struct DistanceFigures {
  double mean = 0, p95 = 0, max = 0;
  Vec3 place = Vec3::Zero();  // the sample that is farthest away
};

struct SurfaceDistance {
  DistanceFigures from_made;   // samples of the made surface to the given one
  DistanceFigures from_given;  // and back
  /// The larger of both directions.
  double p95() const { return from_made.p95 > from_given.p95 ? from_made.p95 : from_given.p95; }
  double max() const { return from_made.max > from_given.max ? from_made.max : from_given.max; }
  double inner_share = 0;  // share of the given area that bounds no solid and was left out
};

/// Two-sided distance between a surface that was made from another and this other one.
///
/// Equal input gives equal figures for any number of threads; time near-linear in triangles and
/// samples.
/// @param solid  if not null, the winding number of `given`: samples where it does not pass 1/2,
///               such as faces inside overlaps, are left out of `from_given`
/// @param samples  in each direction; even over the area
/// @return zeros for a direction without samples
SurfaceDistance surface_distance(const TriMesh& made, const TriMesh& given,
                                 const WindingNumber* solid, Context& ctx, double samples = 20000);

}  // namespace s3
