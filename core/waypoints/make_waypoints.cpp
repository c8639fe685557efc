#include "waypoints/make_waypoints.h"

#include <cmath>
#include <utility>

#include "base/units.h"
#include "waypoints/printed_space.h"
#include "waypoints/resample.h"

namespace s3 {
namespace {

void check(const WaypointSettings& settings) {
  const std::pair<const char*, double> values[] = {
      {"spacing", settings.spacing},         {"chord tolerance", settings.chord_tolerance},
      {"clearance", settings.clearance},     {"filament diameter", settings.filament_diameter},
      {"print speed", settings.print_speed}, {"travel speed", settings.travel_speed},
      {"largest flow", settings.max_flow}};
  for (const auto& [name, value] : values)
    if (!(value > 0) || !std::isfinite(value))
      throw Error(
          ErrorKind::input, Stage::waypoints, "waypoints.bad_settings",
          std::string("The ") + name + " must be positive, not " + std::to_string(value) + ".",
          "Correct the machine profile or toolpath.spacing.");
}

/// Grows the arrays of Waypoints one by one.
class Recorder {
 public:
  struct Row {
    Vec3 position, normal, tangent = Vec3::Zero();
    double width = 0, height = 0, extrusion = 0, speed = 0;
    Index component = 0, layer = 0, path = 0;
    PathKind kind = PathKind::wall;
    bool travel = false;
  };
  void add(const Row& row) { rows_.push_back(row); }
  bool empty() const { return rows_.empty(); }
  const Row& last() const { return rows_.back(); }

  Waypoints finish() const {
    Waypoints w;
    const auto n = static_cast<Eigen::Index>(rows_.size());
    w.position.resize(n, 3);
    w.normal.resize(n, 3);
    w.tangent.resize(n, 3);
    for (Values* v : {&w.width, &w.height, &w.extrusion, &w.speed}) v->resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Row& row = rows_[static_cast<std::size_t>(i)];
      w.position.row(i) = row.position;
      w.normal.row(i) = row.normal;
      w.tangent.row(i) = row.tangent;
      w.width(i) = row.width;
      w.height(i) = row.height;
      w.extrusion(i) = row.extrusion;
      w.speed(i) = row.speed;
      w.component.push_back(row.component);
      w.layer.push_back(row.layer);
      w.path.push_back(row.path);
      w.kind.push_back(row.kind);
      w.travel.push_back(row.travel ? 1 : 0);
    }
    return w;
  }

 private:
  std::vector<Row> rows_;
};

/// Direction of travel at point i, in the plane at a right angle to the normal.
Vec3 tangent_at(const Path& path, Eigen::Index i) {
  const Eigen::Index n = path.points.rows();
  const bool closed = (path.points.row(0) - path.points.row(n - 1)).squaredNorm() == 0;
  const Eigen::Index before = i > 0 ? i - 1 : (closed ? n - 2 : 0);
  const Eigen::Index after = i + 1 < n ? i + 1 : (closed ? 1 : n - 1);
  const Vec3 normal = path.normals.row(i);
  Vec3 tangent = path.points.row(after) - path.points.row(before);
  tangent -= normal * normal.dot(tangent);
  // Back on its own track: the direction in which the point was reached.
  if (tangent.norm() < 1e-9)
    tangent = path.points.row(i) - path.points.row(before == i ? after : before);
  tangent -= normal * normal.dot(tangent);
  return tangent.squaredNorm() > 0 ? Vec3(tangent.normalized()) : Vec3(normal.unitOrthogonal());
}

/// Direction from a to b at a right angle to the normal; any such direction where they lie along
/// the normal.
Vec3 travel_direction(const Vec3& a, const Vec3& b, const Vec3& normal) {
  const Vec3 way = b - a, tangent = way - normal * normal.dot(way);
  return tangent.norm() > 1e-6 * way.norm() && tangent.norm() > 0 ? Vec3(tangent.normalized())
                                                                  : Vec3(normal.unitOrthogonal());
}

Vec3 blend_normal(const Vec3& a, const Vec3& b, double t) {
  const Vec3 n = (1 - t) * a + t * b;
  return n.squaredNorm() > 1e-12 ? Vec3(n.normalized()) : a;
}

class Writer {
 public:
  Writer(const WaypointSettings& settings, Context& ctx)
      : settings_(settings),
        ctx_(ctx),
        space_(2 * settings.clearance),
        area_(kPi / 4 * settings.filament_diameter * settings.filament_diameter) {}

  void add_path(const Path& path, Index component, Index layer) {
    if (path.points.rows() < 2) return;
    Recorder::Row row;
    row.component = component;
    row.layer = layer;
    row.path = path_number_++;
    row.kind = path.kind;
    travel_to(path, row);
    for (Eigen::Index i = 0; i < path.points.rows(); ++i) {
      row.position = path.points.row(i);
      row.normal = path.normals.row(i);
      row.tangent = tangent_at(path, i);
      row.width = path.width(i);
      row.height = path.thickness(i);
      row.travel = i == 0;
      if (i == 0) {
        row.extrusion = 0;
        row.speed = settings_.travel_speed;
      } else {
        const double length = (path.points.row(i) - path.points.row(i - 1)).norm();
        const double section = 0.25 * (path.width(i) + path.width(i - 1)) *
                               (path.thickness(i) + path.thickness(i - 1));
        row.extrusion = section * length / area_;
        row.speed = section > 0 ? std::min(settings_.print_speed, settings_.max_flow / section)
                                : settings_.print_speed;
        add_printed(path.points.row(i - 1), path.points.row(i));
      }
      recorder_.add(row);
    }
  }

  Waypoints finish() {
    if (!recorder_.empty()) {
      Recorder::Row row = recorder_.last();
      const double lift = 1.5 * settings_.clearance, up = space_.top() + 10 * settings_.clearance;
      row.extrusion = row.width = row.height = 0;
      row.speed = settings_.travel_speed;
      row.travel = true;
      row.position += lift * row.normal;
      recorder_.add(row);
      row.position.z() = std::max(row.position.z(), up);
      recorder_.add(row);
    }
    if (!blocked_.empty())
      ctx_.warn("waypoints.travel_blocked",
                std::to_string(blocked_.size()) +
                    " travels may touch what is printed: no free way was found for them.",
                blocked_);
    return recorder_.finish();
  }

 private:
  void add_printed(const Vec3& a, const Vec3& b) {
    const int pieces = 1 + static_cast<int>((b - a).norm() / (0.5 * settings_.clearance));
    for (int k = 1; k <= pieces; ++k) space_.add(a + (b - a) * (static_cast<double>(k) / pieces));
  }

  void travel_to(const Path& path, Recorder::Row row) {
    const Vec3 end = path.points.row(0), end_normal = path.normals.row(0);
    row.travel = true;
    row.speed = settings_.travel_speed;
    row.tangent = tangent_at(path, 0);  // on the first approach
    if (recorder_.empty()) {
      row.normal = end_normal;
      row.position = end + 10 * settings_.clearance * end_normal;
      recorder_.add(row);
      return;
    }
    const Vec3 start = recorder_.last().position, start_normal = recorder_.last().normal;
    if ((start - end).norm() < 1e-9) return;
    const Travel travel =
        find_travel(space_, start, start_normal, end, end_normal, settings_.clearance);
    if (!travel.clear) blocked_.push_back(end);
    const std::size_t n = travel.points.size();
    for (std::size_t i = 0; i < n; ++i) {
      row.position = travel.points[i];
      // The head turns while it is above the print.
      row.normal = blend_normal(start_normal, end_normal,
                                n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 1);
      row.tangent =
          travel_direction(i == 0 ? start : travel.points[i - 1], row.position, row.normal);
      recorder_.add(row);
    }
  }

  const WaypointSettings& settings_;
  Context& ctx_;
  PrintedSpace space_;
  double area_;  // mm² of filament
  Recorder recorder_;
  Index path_number_ = 0;
  std::vector<Vec3> blocked_;
};

}  // namespace

Waypoints make_waypoints(const LayerStack& stack, const Toolpaths& toolpaths,
                         const WaypointSettings& settings, Context& ctx) {
  check(settings);
  const std::size_t n = toolpaths.layers.size();
  std::vector<std::vector<Path>> resampled(n);
  parallel_for(ctx.pool, n, 1, [&](std::size_t begin, std::size_t end) {
    ctx.checkpoint();
    for (std::size_t i = begin; i < end; ++i)
      for (const Path& path : toolpaths.layers[i].paths)
        resampled[i].push_back(resample(path, settings.spacing, settings.chord_tolerance));
  });
  Writer writer(settings, ctx);
  for (std::size_t i = 0; i < n; ++i) {
    const Index component = toolpaths.layers[i].component;
    const Index layer = stack.layers[static_cast<std::size_t>(component)].layer;
    for (const Path& path : resampled[i]) writer.add_path(path, component, layer);
    ctx.progress(Stage::waypoints, static_cast<double>(i + 1) / static_cast<double>(n));
  }
  return writer.finish();
}

}  // namespace s3
