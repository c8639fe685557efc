// From the phase of a stripe pattern to lines on the layer.
#pragma once
#include <vector>

#include "toolpaths/stripe_mesh.h"
#include "toolpaths/stripe_pattern.h"

namespace s3 {

/// A curve of constant phase: points on mesh edges.
struct StripeLine {
  struct Node {
    Index edge;
    double fraction;  // from the edge's first end
  };
  std::vector<Node> nodes;
  std::vector<Index> triangles;  // one for each piece between two nodes
  bool closed = false;           // a piece joins the last node to the first
};

/// The curves φ = π modulo 2π, complete in every triangle in which the phase is linear. In singular
/// triangles lines end, or turn around the singularity of the line field.
std::vector<StripeLine> trace_stripes(const StripeMesh& mesh, const StripePattern& pattern);

}  // namespace s3
