#include "tetrahedralize/lattice_cuts.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace s3 {

namespace {

constexpr std::size_t kChunk = 256;
// Bisection steps where the surface has a hole: the cut is 2⁻¹² of an edge sharp, coarse enough
// that rounding never decides a step.
constexpr int kBisections = 12;
// A block of lattice vertices counts as one when the surface is this many of its radii away from
// its middle, and the winding number there this far from 1/2.
constexpr double kFarRadii = 2;
constexpr double kSureOf = 0.35;
constexpr double kMaxLevel = 100;

// Half-open ranges of cells.
struct Block {
  std::array<Index, 3> low, high;
  Index cells() const { return (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2]); }
};

class Classifier {
 public:
  Classifier(const BccLattice& lattice, const SurfaceSolid& solid,
             std::vector<signed char>& winding)
      : lattice_(lattice), solid_(solid), winding_(winding) {}

  // Sets whole blocks far from the surface at once.
  void visit(const Block& block) {
    const auto corner = [&](const std::array<Index, 3>& cell) {
      return Vec3(lattice_.position({cell, 0}));
    };
    // From the first corner to the last centre.
    const Vec3 low = corner(block.low),
               high = corner(block.high) - Vec3::Constant(0.5 * lattice_.size),
               middle = 0.5 * (low + high);
    const double reach = kFarRadii * 0.5 * (high - low).norm();
    if (block.cells() > 1) {
      if (solid_.tree.closest(middle, reach).triangle < 0) {
        const double w = solid_.winding.at(middle);
        if (std::abs(w - 0.5) > kSureOf) return set(block, level(w));
      }
      return split(block);
    }
    for (int kind = 0; kind < 2; ++kind) {
      const BccLattice::Place p{block.low, kind};
      winding_[static_cast<std::size_t>(lattice_.index(p))] =
          level(solid_.winding.at(lattice_.position(p)));
    }
  }

 private:
  // Positive exactly where the winding number is over 1/2.
  static signed char level(double w) {
    return static_cast<signed char>(std::clamp(std::ceil(w - 0.5), -kMaxLevel, kMaxLevel));
  }

  void set(const Block& block, signed char level) {
    if (level == 0) return;  // as they are
    for (Index z = block.low[2]; z < block.high[2]; ++z)
      for (Index y = block.low[1]; y < block.high[1]; ++y)
        for (Index x = block.low[0]; x < block.high[0]; ++x)
          for (int kind = 0; kind < 2; ++kind)
            winding_[static_cast<std::size_t>(lattice_.index({{x, y, z}, kind}))] = level;
  }

  void split(const Block& block) {
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (block.high[k] - block.low[k] > block.high[axis] - block.low[axis]) axis = k;
    Block first = block, second = block;
    first.high[axis] = second.low[axis] = (block.low[axis] + block.high[axis]) / 2;
    visit(first);
    visit(second);
  }

  const BccLattice& lattice_;
  const SurfaceSolid& solid_;
  std::vector<signed char>& winding_;
};

double bisect(const Vec3& inner, const Vec3& outer, const WindingNumber& winding, double& low,
              double& high) {
  low = 0;
  high = 1;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (winding.is_inside(inner + middle * (outer - inner)) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

void find_cut(LatticeCut& cut, const BccLattice& lattice, const SurfaceSolid& solid) {
  const Vec3 inner = lattice.position(cut.inner), way = lattice.position(cut.outer) - inner;
  const std::vector<RayHit> hits = solid.tree.all_hits(inner, way, 1.0);
  const auto jump = [&] { return solid.winding.at(inner) - solid.winding.at(inner + way); };
  constexpr double kJumpSlack = 0.1;
  if (hits.size() == 1 && std::abs(jump() - 1) < kJumpSlack) {
    cut.t = hits[0].t;
  } else {
    double low, high;
    cut.t = bisect(inner, inner + way, solid.winding, low, high);
    for (const RayHit& hit : hits)
      if (hit.t >= low && hit.t <= high) cut.t = hit.t;
  }
  cut.point = inner + cut.t * way;
}

}  // namespace

std::vector<signed char> winding_at_vertices(const BccLattice& lattice, const SurfaceSolid& solid,
                                             Context& ctx) {
  std::vector<signed char> winding(static_cast<std::size_t>(lattice.count()), 0);
  // Slabs of cells as jobs: enough of them for any number of threads.
  constexpr Index kSlab = 4;
  const auto slabs = static_cast<std::size_t>((lattice.counts[2] + kSlab - 1) / kSlab);
  parallel_for(ctx.pool, slabs, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      ctx.checkpoint();
      const auto z = kSlab * static_cast<Index>(s);
      Classifier(lattice, solid, winding)
          .visit({{0, 0, z},
                  {lattice.counts[0], lattice.counts[1], std::min(z + kSlab, lattice.counts[2])}});
    }
  });
  return winding;
}

std::vector<LatticeCut> lattice_cuts(const BccLattice& lattice,
                                     const std::vector<signed char>& winding,
                                     const SurfaceSolid& solid, Context& ctx) {
  std::vector<LatticeCut> cuts;
  std::array<Index, 11> others;
  for (Index v = 0; v < lattice.count(); ++v) {
    const int n = lattice.own_edges(v, others);
    for (int i = 0; i < n; ++i) {
      const Index other = others[static_cast<std::size_t>(i)];
      const bool v_inside = winding[static_cast<std::size_t>(v)] > 0;
      if (v_inside == (winding[static_cast<std::size_t>(other)] > 0)) continue;
      cuts.push_back({v_inside ? v : other, v_inside ? other : v, 0, Vec3::Zero()});
    }
  }
  parallel_for(ctx.pool, cuts.size(), kChunk, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    for (std::size_t i = begin; i < end; ++i) find_cut(cuts[i], lattice, solid);
  });
  return cuts;
}

}  // namespace s3
