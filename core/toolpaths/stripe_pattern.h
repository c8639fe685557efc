// Evenly spaced stripes along a line field (Knöppel et al. 2015, "Stripe patterns on surfaces").
#pragma once
#include <vector>

#include "base/context.h"
#include "toolpaths/stripe_mesh.h"

namespace s3 {

/// A phase that rises by 2π from one stripe to the next. At each vertex it is counted in the
/// direction normal × line; on edges between lines of opposite orientation it changes its sign.
struct StripePattern {
  Values phase;              // #V rad in (−π, π)
  Values rise;               // #E rad from an edge's first end to its second, as the first counts
  std::vector<char> mirror;  // #E: the ends count in opposite directions
};

/// Phases that the pattern should have at some vertices.
struct StripeAnchors {
  Values weight;  // #V ≥ 0, relative to vertex area; 0 for none
  Values phase;   // #V rad
};

/// Minimises the jump of e^{iφ} along the edges against the rise that the lines and the spacing ask
/// for, for unit vectors: by steps of implicit diffusion, each followed by normalisation, from far
/// to near (Merriman, Bence & Osher 1992). Where lines diverge, new ones begin at singular
/// triangles, so that the spacing stays.
/// @param line  #V×3 unit tangents up to sign
/// @param spacing  mm between stripes
StripePattern stripe_pattern(const StripeMesh& mesh, const Directions& line,
                             const StripeAnchors& anchors, double spacing, const Context& ctx);

}  // namespace s3
