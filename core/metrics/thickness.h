// How thick the layers are (Sec. 4.2): figures and what the histogram shows.
#pragma once
#include <vector>

#include "base/context.h"
#include "layers/layer.h"
#include "metrics/metrics.h"
#include "metrics/svg_plot.h"

namespace s3 {

/// One value a layer vertex: the thickness (mm) that slicing stored there, with its share of the
/// layer's area (mm²).
std::vector<WeightedValue> thickness_values(const LayerStack& stack);

/// Fills layers, components, thickness_mm and thickness_outside_area_percent, measured anew from
/// the surfaces; without any layer area the thickness stays empty.
void layer_metrics(const LayerStack& stack, double d_min, double d_max, Metrics& metrics,
                   Context& ctx);

}  // namespace s3
