// What a picture shows: layers as coloured sheets, toolpaths as beads, the part with its field.
#pragma once
#include <vector>

#include "layers/layer.h"
#include "mesh/tet_mesh.h"
#include "picture/rasterizer.h"
#include "waypoints/waypoints.h"

namespace s3 {

/// A colour for t in [0, 1]: dark blue over green to yellow (viridis), readable without colour
/// vision.
Color viridis(double t);

struct PictureOptions {
  double first = 0, last = 1;  // the share of the layers, by print order, that is drawn
  double explode = 0;          // mm between layers, added along z
  double cut = -1e300;         // mm: only what lies at y > cut is drawn
};

/// Layers with their boundary drawn as lines.
void draw_layers(Rasterizer& target, const LayerStack& stack, const PictureOptions& options);
/// Beads of the printed moves as prisms of their width and height.
void draw_toolpaths(Rasterizer& target, const Waypoints& waypoints, const PictureOptions& options);
/// The surface of the part with bands of equal G; faces in `marked` (one flag a boundary face) in
/// red.
void draw_surface(Rasterizer& target, const TetMesh& mesh, const Values& field,
                  const std::vector<char>& marked);

}  // namespace s3
