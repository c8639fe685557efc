#include "waypoints/printed_space.h"

#include <algorithm>
#include <cmath>

namespace s3 {
namespace {

/// Whether all of a segment keeps its distance.
bool segment_clear(const PrintedSpace& space, const Vec3& a, const Vec3& b, double clearance) {
  const int steps = 1 + static_cast<int>((b - a).norm() / (0.5 * clearance));
  for (int i = 0; i <= steps; ++i)
    if (space.distance(a + (b - a) * (static_cast<double>(i) / steps)) < clearance) return false;
  return true;
}

/// The way up from a point on the print: at height t nothing may be nearer than 0.7 t.
bool lift_clear(const PrintedSpace& space, const Vec3& from, const Vec3& normal, double height,
                double clearance) {
  const int steps = 2 + static_cast<int>(height / (0.5 * clearance));
  for (int i = 1; i <= steps; ++i) {
    const double t = height * i / steps;
    if (space.distance(from + t * normal) < std::min(clearance, 0.7 * t)) return false;
  }
  return true;
}

bool way_clear(const PrintedSpace& space, const std::vector<Vec3>& points, double clearance) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    if (!segment_clear(space, points[i], points[i + 1], clearance)) return false;
  return std::all_of(points.begin(), points.end(), [&](const Vec3& p) { return p.z() > 0; });
}

}  // namespace

std::size_t PrintedSpace::Hash::operator()(const Key& k) const {
  std::uint64_t h = static_cast<std::uint64_t>(k.x) * 0x9E3779B97F4A7C15u ^
                    static_cast<std::uint64_t>(k.y) * 0xC2B2AE3D27D4EB4Fu ^
                    static_cast<std::uint64_t>(k.z) * 0x165667B19E3779F9u;
  h ^= h >> 31;
  return static_cast<std::size_t>(h);
}

PrintedSpace::Key PrintedSpace::key_of(const Vec3& p) const {
  return {static_cast<std::int64_t>(std::floor(p.x() * scale_)),
          static_cast<std::int64_t>(std::floor(p.y() * scale_)),
          static_cast<std::int64_t>(std::floor(p.z() * scale_))};
}

void PrintedSpace::add(const Vec3& point) {
  cells_[key_of(point)].push_back(point);
  top_ = std::max(top_, point.z());
}

double PrintedSpace::distance(const Vec3& place) const {
  double squared = reach_ * reach_;
  const Key c = key_of(place);
  for (std::int64_t x = c.x - 1; x <= c.x + 1; ++x)
    for (std::int64_t y = c.y - 1; y <= c.y + 1; ++y)
      for (std::int64_t z = c.z - 1; z <= c.z + 1; ++z) {
        const auto cell = cells_.find({x, y, z});
        if (cell == cells_.end()) continue;
        for (const Vec3& p : cell->second) squared = std::min(squared, (p - place).squaredNorm());
      }
  return std::sqrt(squared);
}

Travel find_travel(const PrintedSpace& space, const Vec3& start, const Vec3& start_normal,
                   const Vec3& end, const Vec3& end_normal, double clearance) {
  constexpr double kStep = 1.5;  // of the clearance: the first lift; doubled until the way is free
  constexpr int kDoublings = 7;
  const double safe = space.top() + 1.5 * clearance;
  Travel travel;
  for (int k = 0; k < kDoublings; ++k) {
    const double height = kStep * clearance * (1 << k);
    if (!lift_clear(space, start, start_normal, height, clearance) ||
        !lift_clear(space, end, end_normal, height, clearance))
      continue;
    const Vec3 a = start + height * start_normal, b = end + height * end_normal;
    travel.points = {a, b};
    if (way_clear(space, travel.points, clearance)) return travel;
    // Not straight across, then above everything.
    if (k % 2 == 0) continue;
    travel.points = {a, Vec3(a.x(), a.y(), std::max(a.z(), safe)),
                     Vec3(b.x(), b.y(), std::max(b.z(), safe)), b};
    if (way_clear(space, travel.points, clearance)) return travel;
  }
  const Vec3 a = start + kStep * clearance * start_normal, b = end + kStep * clearance * end_normal;
  travel.points = {a, Vec3(a.x(), a.y(), std::max(a.z(), safe)),
                   Vec3(b.x(), b.y(), std::max(b.z(), safe)), b};
  travel.clear = false;
  return travel;
}

}  // namespace s3
