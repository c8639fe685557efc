#include "toolpaths/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "toolpaths/point_grid.h"

namespace s3 {
namespace {

constexpr double kSampleDistance = 0.2;  // of w
constexpr double kSliver = 0.002;        // of w: gaps and overlaps narrower than this are rounding
constexpr double kStrandGap = 1.5;       // of w, along the path

struct Segment {
  Vec3 a, along, normal;  // along: from a to b
  double length, per_squared_length;
  double width_a, width_b;
  double from;  // position along the path, mm
  Index path;
};

struct Strand {
  Index path;
  double first, last;  // along the path, mm
};

double squared_distance(const Vec3& p, const Segment& s, double& t) {
  const Vec3 from = p - s.a;
  t = std::clamp(from.dot(s.along) * s.per_squared_length, 0.0, 1.0);
  return (from - t * s.along).squaredNorm();
}

std::vector<Segment> make_segments(const std::vector<Path>& paths, std::vector<double>& lengths) {
  std::vector<Segment> segments;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const Path& path = paths[k];
    const Eigen::Index n = path.points.rows();
    double from = 0;
    for (Eigen::Index i = 0; i + 1 < n + (path.closed ? 1 : 0); ++i) {
      const Eigen::Index j = (i + 1) % n;
      const Vec3 a = path.points.row(i), along = Vec3(path.points.row(j)) - a;
      const double length = along.norm();
      segments.push_back({a, along, path.normals.row(i), length,
                          length > 0 ? 1 / (length * length) : 0, path.width(i), path.width(j),
                          from, static_cast<Index>(k)});
      from += length;
    }
    lengths.push_back(path.closed ? from : std::numeric_limits<double>::infinity());
  }
  return segments;
}

/// How many strands there are among the touching segments.
std::size_t count_strands(std::vector<Strand>& touching, const std::vector<double>& lengths,
                          double gap) {
  std::sort(touching.begin(), touching.end(), [](const Strand& a, const Strand& b) {
    return a.path != b.path ? a.path < b.path : a.first < b.first;
  });
  std::size_t count = 0;
  for (std::size_t begin = 0; begin < touching.size();) {
    std::size_t end = begin, strands = 1;
    double last = touching[begin].last;
    while (++end < touching.size() && touching[end].path == touching[begin].path) {
      if (touching[end].first - last > gap) ++strands;
      last = std::max(last, touching[end].last);
    }
    // A closed path goes on from its end to its start.
    const double around =
        touching[begin].first + lengths[static_cast<std::size_t>(touching[begin].path)] - last;
    if (strands > 1 && around <= gap) --strands;
    count += strands;
    begin = end;
  }
  return count;
}

}  // namespace

Coverage measure_coverage(const LayerMesh& layer, const Values& distance,
                          const std::vector<InnerDisc>& discs, const std::vector<Path>& paths,
                          double width, double least_width, const Context& ctx) {
  std::vector<double> lengths;
  const std::vector<Segment> segments = make_segments(paths, lengths);
  double widest = width;
  for (const Path& path : paths)
    widest = std::max(widest, path.width.size() > 0 ? path.width.maxCoeff() : 0.0);
  // Segments are found from a triangle's middle through points along them, at most a quarter of the
  // widest bead away.
  const double triangle_reach = longest_edge(layer) / std::sqrt(3.0);
  PointGrid grid(0.75 * widest + triangle_reach);
  std::vector<Index> owner;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const Segment& segment = segments[s];
    const int pieces = 1 + static_cast<int>(segment.length / (0.5 * widest));
    for (int i = 0; i < pieces; ++i) {
      grid.add(segment.a + segment.along * ((i + 0.5) / pieces));
      owner.push_back(static_cast<Index>(s));
    }
  }
  grid.finish();
  PointGrid deep(1.3 * width + triangle_reach), any(width);
  std::vector<double> deep_radius, any_radius;
  for (const InnerDisc& disc : discs) {
    if (disc.radius >= width) {
      deep.add(disc.center);
      deep_radius.push_back(disc.radius);
    }
    if (2 * disc.radius < least_width) continue;
    any.add(disc.center);
    any_radius.push_back(disc.radius);
  }
  deep.finish();
  any.finish();

  Coverage result;
  const double sliver = kSliver * width;
  std::vector<Strand> touching;
  std::vector<Index> near, near_deep;
  for (Eigen::Index f = 0; f < layer.triangles.rows(); ++f) {
    if (f % 1024 == 0) ctx.checkpoint();
    std::array<Vec3, 3> v;
    for (int k = 0; k < 3; ++k)
      v[static_cast<std::size_t>(k)] = layer.vertices.row(layer.triangles(f, k));
    const Vec3 cross = (v[1] - v[0]).cross(v[2] - v[0]);
    const double area = 0.5 * cross.norm();
    if (area == 0) continue;
    const Vec3 normal = cross / (2 * area);
    const double longest =
        std::max({(v[1] - v[0]).norm(), (v[2] - v[1]).norm(), (v[0] - v[2]).norm()});
    const int m = std::max(1, static_cast<int>(std::ceil(longest / (kSampleDistance * width))));
    const double part = area / (m * m);
    result.area += area;
    const Vec3 middle = (v[0] + v[1] + v[2]) / 3;
    const double reach =
        std::sqrt(std::max({(v[0] - middle).squaredNorm(), (v[1] - middle).squaredNorm(),
                            (v[2] - middle).squaredNorm()}));
    near.clear();
    grid.visit(middle, [&](Index point) {
      const Index s = owner[static_cast<std::size_t>(point)];
      const Segment& segment = segments[static_cast<std::size_t>(s)];
      const double far = 0.5 * std::max(segment.width_a, segment.width_b) + sliver + reach;
      double t = 0;
      if (segment.normal.dot(normal) >= 0.3 && squared_distance(middle, segment, t) <= far * far)
        near.push_back(s);
    });
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    double depth = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) depth = std::min(depth, distance(layer.triangles(f, k)));
    near_deep.clear();
    if (depth < width)
      deep.visit(middle, [&](Index d) {
        if ((deep.point(d) - middle).norm() <= 1.3 * width + reach) near_deep.push_back(d);
      });
    // The nearest first: it settles the question for most samples.
    if (!near_deep.empty())
      std::iter_swap(near_deep.begin(),
                     std::min_element(near_deep.begin(), near_deep.end(), [&](Index a, Index b) {
                       return (deep.point(a) - middle).squaredNorm() <
                              (deep.point(b) - middle).squaredNorm();
                     }));
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < 2 * (m - i) - 1; ++j) {
        // Centre of small triangle j in row i of the subdivision.
        const int column = j / 2;
        const double along = (column + (j % 2 == 0 ? 1.0 : 2.0) / 3) / m,
                     up = (i + (j % 2 == 0 ? 1.0 : 2.0) / 3) / m;
        const Vec3 p = v[0] + along * (v[1] - v[0]) + up * (v[2] - v[0]);
        touching.clear();
        bool covered = false;
        for (const Index n : near) {
          const Segment& segment = segments[static_cast<std::size_t>(n)];
          double t = 0;
          const double squared = squared_distance(p, segment, t);
          const double half = 0.5 * ((1 - t) * segment.width_a + t * segment.width_b);
          if (squared > (half + sliver) * (half + sliver)) continue;
          covered = true;
          if (squared > (half - sliver) * (half - sliver)) continue;
          const double position = segment.from + t * segment.length;
          touching.push_back({segment.path, position, position});
        }
        const std::size_t strands = touching.size() < 2
                                        ? touching.size()
                                        : count_strands(touching, lengths, kStrandGap * width);
        if (covered) result.covered += part;
        if (!covered) {
          bool fits = false;
          any.visit(p, [&](Index d) {
            fits = fits || (any.point(d) - p).norm() <= any_radius[static_cast<std::size_t>(d)];
          });
          if (!fits) result.thin += part;
        }
        const bool wide =
            depth >= width || std::any_of(near_deep.begin(), near_deep.end(), [&](Index d) {
              return (deep.point(d) - p).norm() <= deep_radius[static_cast<std::size_t>(d)];
            });
        if (!wide) continue;
        result.wide += part;
        if (strands > 1) result.overlap += part * static_cast<double>(strands - 1);
      }
  }
  return result;
}

}  // namespace s3
