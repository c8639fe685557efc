#include "mesh/orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "base/units.h"
#include "mesh/aabb_tree.h"
#include "mesh/planar_hull.h"
#include "mesh/resting_pose.h"
#include "mesh/surface_points.h"
#include "mesh/tri_mesh.h"

namespace s3 {
namespace {

constexpr std::size_t kFlatCandidates = 60;
constexpr int kSphereCandidates = 200;
constexpr int kDrops = 40;               // releases of the model to find poses of rest
constexpr double kFlatBins = 1000;       // cells per unit of a normal's coordinates: about 0.06°
constexpr double kSameDirection = 0.05;  // degrees: candidates nearer than this are one
constexpr double kDistinct = 10;         // degrees between any two results
constexpr double kContactHeight = 1e-3;  // of the height: what touches the plate
constexpr double kPlateHeight = 1e-2;    // of the height: what needs no support so near the plate
constexpr double kPlateNormal = 0.9;
constexpr double kStableTipping = 12;  // degrees
constexpr double kTippingCost = 1;
constexpr double kLeastContact = 0.02;  // of the shadow
constexpr double kPointCost = 1;
constexpr double kSupportDensity = 0.2;
constexpr double kEqualCost = 0.01;
constexpr double kEqualContact = 0.02;  // of the largest
constexpr double kEqualHeight = 0.01;   // of the least
constexpr std::size_t kRoughSamples = 4096, kFineSamples = 32768;
constexpr std::size_t kRefined = 5, kFinalists = 24;
// Normals of exact 45° slopes come with single-precision noise.
constexpr double kOverhang = std::numbers::sqrt2 / 2 + 1e-5;

struct Candidate {
  Orientation figures;
  double cost = 0;
  std::size_t order = 0;  // of its finding
};

double angle_deg(const Vec3& a, const Vec3& b) {
  return degrees(std::atan2(a.cross(b).norm(), a.dot(b)));
}

// Vertices that no triangle uses must not carry the model.
TriMesh used_part(const Points& vertices, const Triangles& triangles) {
  TriMesh mesh{Points(vertices.rows(), 3), triangles};
  std::vector<Index> number(static_cast<std::size_t>(vertices.rows()), -1);
  Index count = 0;
  for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i) {
    Index& v = mesh.triangles.data()[i];
    Index& renamed = number[static_cast<std::size_t>(v)];
    if (renamed < 0) {
      renamed = count++;
      mesh.vertices.row(renamed) = vertices.row(v);
    }
    v = renamed;
  }
  mesh.vertices.conservativeResize(count, 3);
  return mesh;
}

/// The surface with all that does not depend on the direction.
class Body {
 public:
  Body(const Points& vertices, const Triangles& triangles)
      : mesh_(used_part(vertices, triangles)),
        normals_(triangles.rows(), 3),
        areas_(triangles.rows()),
        tree_(mesh_),
        diagonal_(bounding_box(mesh_.vertices).diagonal()) {
    if (mesh_.triangles.rows() > 0) measure_faces();
    rough_ = spread_points(mesh_, kRoughSamples);
    fine_ = spread_points(mesh_, kFineSamples);
  }

  const Points& vertices() const { return mesh_.vertices; }
  const Directions& normals() const { return normals_; }
  double area(Eigen::Index f) const { return areas_[f]; }
  const Vec3& center_of_mass() const { return center_; }
  /// False for what has no extent, or one beyond numbers.
  bool measurable() const {
    return mesh_.triangles.rows() > 0 && total_area_ > 0 && std::isfinite(total_area_) &&
           std::isfinite(volume_scale_) && volume_scale_ > 0 && center_.allFinite();
  }

  Orientation figures(const Vec3& up, bool fine) const;
  double cost(const Orientation& o) const;

 private:
  void measure_faces();
  void measure_contact(const Vec3& up, const Eigen::VectorXd& heights, double low,
                       Orientation& o) const;

  TriMesh mesh_;
  Directions normals_;  // unit, 0 for faces without area
  Values areas_;
  AabbTree tree_;
  double diagonal_;
  double total_area_ = 0, volume_scale_ = 0;
  Vec3 center_ = Vec3::Zero();
  std::vector<SurfacePoint> rough_, fine_;
};

void Body::measure_faces() {
  const Vec3 origin = mesh_.vertices.row(0);
  Vec3 area_moment = Vec3::Zero(), volume_moment = Vec3::Zero();
  double volume = 0;
  for (Eigen::Index f = 0; f < mesh_.triangles.rows(); ++f) {
    const Vec3 n = triangle_normal_2a(mesh_.vertices, mesh_.triangles.row(f));
    const double length = n.norm();
    normals_.row(f) = length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
    areas_[f] = 0.5 * length;
    total_area_ += 0.5 * length;
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
      sum += mesh_.vertices.row(mesh_.triangles(f, i)).transpose() - origin;
    // A tet from the origin to the face: its volume, and its centroid times that.
    const double part = (mesh_.vertices.row(mesh_.triangles(f, 0)).transpose() - origin).dot(n) / 6;
    volume += part;
    volume_moment += part / 4 * sum;
    area_moment += 0.5 * length / 3 * sum;
  }
  // A surface that is not closed has no volume of its own.
  constexpr double kLeastVolume = 1e-3;  // of the diagonal's cube
  const double least = kLeastVolume * diagonal_ * diagonal_ * diagonal_;
  volume_scale_ = std::max(volume, least);
  const Box box = bounding_box(mesh_.vertices);
  const Vec3 center = origin + volume_moment / volume;
  const bool within = volume > 0 && (center.array() >= box.min.array()).all() &&
                      (center.array() <= box.max.array()).all();
  center_ = within ? center : Vec3(origin + area_moment / total_area_);
}

void Body::measure_contact(const Vec3& up, const Eigen::VectorXd& heights, double low,
                           Orientation& o) const {
  const Vec3 u = up.unitOrthogonal(), v = up.cross(u);
  const double limit = low + kPlateHeight * o.height;
  std::vector<Vec2> contact;
  const auto add = [&](const Vec3& p) { contact.emplace_back(p.dot(u), p.dot(v)); };
  for (Eigen::Index i = 0; i < mesh_.vertices.rows(); ++i)
    if (heights[i] <= limit) add(mesh_.vertices.row(i).transpose());
  // Where edges leave the lowest slice: what carries must not depend on where vertices happen to
  // be.
  for (Eigen::Index i = 0; i < mesh_.triangles.size(); ++i) {
    const Index a = mesh_.triangles.data()[i],
                b = mesh_.triangles.data()[i % 3 < 2 ? i + 1 : i - 2];
    if ((heights[a] <= limit) == (heights[b] <= limit)) continue;
    const double s = (limit - heights[a]) / (heights[b] - heights[a]);
    add((1 - s) * mesh_.vertices.row(a) + s * mesh_.vertices.row(b));
  }
  const double inside =
      nearest_border(convex_hull(std::move(contact)), Vec2(center_.dot(u), center_.dot(v))).inside;
  o.tipping_deg = inside > 0 ? degrees(std::atan2(inside, center_.dot(up) - low)) : 0;
  o.stable = o.tipping_deg >= kStableTipping;
}

Orientation Body::figures(const Vec3& up, bool fine) const {
  Orientation o;
  o.up = up;
  Eigen::VectorXd heights;
  heights.noalias() = mesh_.vertices * up;
  const double low = heights.minCoeff();
  o.height = heights.maxCoeff() - low;
  const auto highest_corner = [&](Eigen::Index f) {
    return std::max({heights[mesh_.triangles(f, 0)], heights[mesh_.triangles(f, 1)],
                     heights[mesh_.triangles(f, 2)]}) -
           low;
  };
  const auto needs_support = [&](Eigen::Index f, double nz) {
    return nz < -kOverhang && !(nz < -kPlateNormal && highest_corner(f) <= kPlateHeight * o.height);
  };
  for (Eigen::Index f = 0; f < mesh_.triangles.rows(); ++f) {
    const double nz = normals_.row(f).dot(up);
    if (nz >= -kOverhang) continue;
    if (needs_support(f, nz))
      o.overhang_area += area(f);
    else if (highest_corner(f) <= kContactHeight * o.height)
      o.contact_area -= nz * area(f);
  }
  measure_contact(up, heights, low, o);

  const std::vector<SurfacePoint>& samples = fine ? fine_ : rough_;
  const double clearance = 1e-6 * diagonal_;  // the face itself is no floor
  double sum = 0;
  for (const SurfacePoint& sample : samples) {
    const double nz = normals_.row(sample.face).dot(up);
    if (nz >= -kOverhang || !needs_support(sample.face, nz)) continue;
    const double drop = sample.point.dot(up) - low;
    const RayHit floor = tree_.first_hit(sample.point - clearance * up, -up, drop);
    sum -= nz * (floor.triangle < 0 ? drop : floor.t + clearance);
  }
  if (!samples.empty()) o.support_volume = sum * total_area_ / static_cast<double>(samples.size());
  return o;
}

double Body::cost(const Orientation& o) const {
  // Half the surface faces down, so this is the area of the shadow, more where parts shade parts.
  const double shadow = 0.5 * (normals_ * o.up).cwiseAbs().dot(areas_);
  const auto lack = [](double value, double enough) { return std::max(0.0, 1 - value / enough); };
  return o.overhang_area / total_area_ + kSupportDensity * o.support_volume / volume_scale_ +
         kTippingCost * lack(o.tipping_deg, kStableTipping) +
         kPointCost * lack(o.contact_area, kLeastContact * shadow);
}

// Unit normals of the regions of equal normal, largest area first.
std::vector<Vec3> flat_normals(const Body& body) {
  struct Cell {
    std::array<int, 3> key;
    Eigen::Index face;
  };
  std::vector<Cell> cells;
  for (Eigen::Index f = 0; f < body.normals().rows(); ++f) {
    std::array<int, 3> key;
    for (int k = 0; k < 3; ++k)
      key[static_cast<std::size_t>(k)] =
          static_cast<int>(std::lround(body.normals()(f, k) * kFlatBins));
    cells.push_back({key, f});
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return a.key != b.key ? a.key < b.key : a.face < b.face;
  });
  std::vector<Vec3> sums;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].key != cells[i - 1].key) sums.push_back(Vec3::Zero());
    sums.back() += body.area(cells[i].face) * body.normals().row(cells[i].face).transpose();
  }
  std::stable_sort(sums.begin(), sums.end(),
                   [](const Vec3& a, const Vec3& b) { return a.norm() > b.norm(); });
  if (sums.size() > kFlatCandidates) sums.resize(kFlatCandidates);
  std::vector<Vec3> normals;
  for (const Vec3& sum : sums)
    if (sum.norm() > 0) normals.push_back(sum.normalized());
  return normals;
}

// Point i of an even (Fibonacci) covering of the sphere.
Vec3 sphere_point(int i, int count) {
  const double z = 1 - (2.0 * i + 1) / count;
  const double angle = i * kPi * (3 - std::sqrt(5.0));
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Collects candidates.
class Search {
 public:
  Search(const Body& body, const Context* ctx) : body_(body), ctx_(ctx) {}

  /// @return its place in `candidates`
  std::size_t consider(const Vec3& up) {
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (angle_deg(candidates[i].figures.up, up) < kSameDirection) return i;
    if (ctx_) ctx_->checkpoint();
    Candidate c{body_.figures(up, false), 0, candidates.size()};
    c.cost = body_.cost(c.figures);
    candidates.push_back(c);
    return candidates.size() - 1;
  }

  /// Steps downhill from a candidate, in smaller and smaller circles.
  void refine(std::size_t best) {
    for (double step = radians(8); step > radians(0.5); step /= 2) {
      const Vec3 center = candidates[best].figures.up;
      const Vec3 u = center.unitOrthogonal(), v = center.cross(u);
      for (int k = 0; k < 8; ++k) {
        const double angle = k * kPi / 4;
        const std::size_t next = consider(
            (center + std::tan(step) * (std::cos(angle) * u + std::sin(angle) * v)).normalized());
        if (candidates[next].cost < candidates[best].cost) best = next;
      }
    }
  }

  std::vector<Candidate> candidates;

 private:
  const Body& body_;
  const Context* ctx_;
};

bool less_cost(const Candidate& a, const Candidate& b) {
  return a.cost != b.cost ? a.cost < b.cost : a.order < b.order;
}
bool more_contact(const Candidate& a, const Candidate& b) {
  return a.figures.contact_area != b.figures.contact_area
             ? a.figures.contact_area > b.figures.contact_area
             : less_cost(a, b);
}
bool less_height(const Candidate& a, const Candidate& b) {
  return a.figures.height != b.figures.height ? a.figures.height < b.figures.height
                                              : a.order < b.order;
}

// The best of a set, not empty; see rank_orientations().
Candidate choose(std::vector<Candidate> set, OrientationGoal goal) {
  const auto keep = [&set](auto&& good) {
    set.erase(std::remove_if(set.begin(), set.end(), [&](const Candidate& c) { return !good(c); }),
              set.end());
  };
  const auto keep_contact = [&] {
    const double most =
        std::min_element(set.begin(), set.end(), more_contact)->figures.contact_area;
    keep([&](const Candidate& c) { return c.figures.contact_area >= (1 - kEqualContact) * most; });
  };
  if (goal == OrientationGoal::flat_face) {
    const auto stable = [](const Candidate& c) { return c.figures.stable; };
    if (std::any_of(set.begin(), set.end(), stable)) keep(stable);
    keep_contact();
  }
  const double least = std::min_element(set.begin(), set.end(), less_cost)->cost;
  keep([&](const Candidate& c) { return c.cost <= least + kEqualCost; });
  keep_contact();
  const double lowest = std::min_element(set.begin(), set.end(), less_height)->figures.height;
  keep([&](const Candidate& c) { return c.figures.height <= (1 + kEqualHeight) * lowest; });
  return *std::min_element(set.begin(), set.end(), [](const Candidate& a, const Candidate& b) {
    return a.order < b.order;
  });
}

// Takes the best, drops what is much the same, and so on.
std::vector<Candidate> distinct_best(std::vector<Candidate> set, OrientationGoal goal,
                                     std::size_t count) {
  std::vector<Candidate> best;
  while (!set.empty() && best.size() < count) {
    best.push_back(choose(set, goal));
    const Vec3 up = best.back().figures.up;
    set.erase(
        std::remove_if(set.begin(), set.end(),
                       [&](const Candidate& c) { return angle_deg(c.figures.up, up) < kDistinct; }),
        set.end());
  }
  return best;
}

// Directions in the order in which ties are decided.
void find_candidates(const Body& body, OrientationGoal goal, Search& search) {
  search.consider(Vec3::UnitZ());
  for (const Vec3& normal : flat_normals(body)) search.consider(-normal);
  const auto drop = [&](const Vec3& from) {
    if (const auto up = resting_pose(body.vertices(), body.center_of_mass(), from))
      search.consider(*up);
  };
  for (int i = 0; i < kDrops; ++i) drop(sphere_point(i, kDrops));
  // Models are often modelled along axes.
  for (const double sign : {1.0, -1.0})
    for (int axis = 0; axis < 3; ++axis) {
      drop(sign * Vec3::Unit(axis));
      search.consider(sign * Vec3::Unit(axis));
    }
  if (goal == OrientationGoal::flat_face) return;
  for (int i = 0; i < kSphereCandidates; ++i) search.consider(sphere_point(i, kSphereCandidates));
  for (const Candidate& c : distinct_best(search.candidates, goal, kRefined)) {
    search.refine(c.order);
    drop(c.figures.up);
  }
}

}  // namespace

std::string rotation_text(const Vec3& up) {
  // About x into the plane y = 0, then about y to z.
  const std::array<double, 2> angles = {degrees(std::atan2(up.y(), up.z())),
                                        degrees(-std::atan2(up.x(), std::hypot(up.y(), up.z())))};
  std::string text;
  for (const double angle : angles) {
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), "%.5f", angle);
    std::string word = number.data();
    word.erase(word.find_last_not_of('0') + 1);
    if (word.back() == '.') word.pop_back();
    if (word == "-0" || word == "-180") word.erase(0, 1);
    text += word + ",";
  }
  return text + "0";
}

Orientation measure_orientation(const Points& vertices, const Triangles& triangles,
                                const Vec3& up) {
  const Body body(vertices, triangles);
  Orientation o = body.figures(up, true);
  o.rotate = rotation_text(up);
  return o;
}

std::vector<Orientation> rank_orientations(const Points& vertices, const Triangles& triangles,
                                           OrientationGoal goal, std::size_t count,
                                           const Context* ctx) {
  const Body body(vertices, triangles);
  std::vector<Candidate> best;
  if (body.measurable()) {
    Search search(body, ctx);
    find_candidates(body, goal, search);
    std::vector<Candidate>& set = search.candidates;
    if (goal == OrientationGoal::flat_face)
      set.erase(std::remove_if(set.begin(), set.end(),
                               [](const Candidate& c) { return !(c.figures.contact_area > 0); }),
                set.end());
    // The last comparison, with precise figures.
    set = distinct_best(std::move(set), goal, kFinalists);
    for (Candidate& c : set) {
      c.figures = body.figures(c.figures.up, true);
      c.cost = body.cost(c.figures);
    }
    best = distinct_best(std::move(set), goal, count);
  } else if (goal == OrientationGoal::least_support) {
    best.push_back({{}, 0, 0});
  }
  std::vector<Orientation> result;
  for (Candidate& c : best) {
    c.figures.rotate = rotation_text(c.figures.up);
    result.push_back(std::move(c.figures));
  }
  return result;
}

}  // namespace s3
