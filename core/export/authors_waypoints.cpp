#include "export/authors_waypoints.h"

#include <algorithm>

#include "export/number_text.h"

namespace s3 {
namespace {

constexpr Index kLinesPerCheckpoint = 4096;

}  // namespace

std::vector<std::string> write_authors_waypoints(const Waypoints& waypoints, Context& ctx) {
  Index components = 0;
  for (const Index c : waypoints.component) components = std::max(components, c + 1);
  std::vector<std::string> files(static_cast<std::size_t>(components));
  for (Index i = 0; i < waypoints.size(); ++i) {
    if (i % kLinesPerCheckpoint == 0) ctx.checkpoint();
    const auto k = static_cast<std::size_t>(i);
    // A path begins at the end of a travel.
    const bool begins = waypoints.travel[k] && i + 1 < waypoints.size() && !waypoints.travel[k + 1];
    if (waypoints.travel[k] && !begins) continue;
    std::string& text = files[static_cast<std::size_t>(waypoints.component[k])];
    const Vec3 p = waypoints.position.row(i), n = waypoints.normal.row(i);
    const double values[] = {p.x(), p.z(), -p.y(), -n.x(), -n.z(), n.y()};
    for (int v = 0; v < 6; ++v) {
      if (v > 0) text += ' ';
      append_fixed(text, values[v], 6);
    }
    text += '\n';
  }
  return files;
}

}  // namespace s3
