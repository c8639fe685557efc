#include "outer_loop/residual.h"

#include "base/units.h"
#include "objectives/feasible_region.h"

namespace s3 {

namespace {

struct Sum {
  double distance = 0;
  Index tets = 0;
  Sum& operator+=(const Sum& other) {
    distance += other.distance;
    tets += other.tets;
    return *this;
  }
};

}  // namespace

Residual residual(const ObjectiveField& objectives, const ObjectiveParams& params,
                  const Directions& print_direction, Context& ctx) {
  const RegionBounds bounds = region_bounds(params);
  Residual result;
  result.distance.setZero(print_direction.rows());
  const auto tets = static_cast<std::size_t>(print_direction.rows());
  const Sum sum =
      parallel_sum(ctx.pool, tets, 4096, Sum{}, [&](std::size_t begin, std::size_t end) {
        ctx.checkpoint();
        Sum part;
        for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t) {
          const FeasibleRegion region = feasible_region(objectives, bounds, t);
          if (region.on_plate || !region.constrained()) continue;
          const Vec3 d = print_direction.row(t);
          result.distance(t) = d.isZero(0) ? kPi : project_to_region(region, d).distance;
          part.distance += result.distance(t);
          ++part.tets;
        }
        return part;
      });
  result.tets = sum.tets;
  result.mean = sum.tets > 0 ? sum.distance / sum.tets : 0;
  return result;
}

}  // namespace s3
