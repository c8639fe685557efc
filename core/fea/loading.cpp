#include "fea/loading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "base/error.h"
#include "fea/rigid_motion.h"
#include "mesh/aabb_tree.h"

namespace s3 {
namespace {

constexpr double kContactTolerance = 1e-3;      // of the model's diagonal
const double kContactCosine = std::sqrt(0.75);  // faces within 30° of a plane's normal lie on it
constexpr double kNever = std::numeric_limits<double>::infinity();
// Two displacements of one vertex are the same up to this, mm.
constexpr double kSameDisplacement = 1e-12;
constexpr double kGravityUnit = 1e-6;  // g/cm³ · m/s² in N/mm³

std::string text_of(const Vec3& v) {
  std::array<char, 96> text;
  std::snprintf(text.data(), text.size(), "(%.4g, %.4g, %.4g)", v.x(), v.y(), v.z());
  return text.data();
}

std::string number(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

// How far a point is from a solid shape, mm: 0 or less inside.
double distance(const Vec3& p, const HalfSpace& half) {
  return -(p - half.point).dot(half.normal);
}
double distance(const Vec3& p, const BoxRegion& box) {
  return (box.low - p).cwiseMax(p - box.high).cwiseMax(0.0).norm();
}
double distance(const Vec3& p, const SphereRegion& sphere) {
  return (p - sphere.center).norm() - sphere.radius;
}
// The others are of the surface alone.
double distance(const Vec3&, const PlateContact&) {
  return kNever;
}
double distance(const Vec3&, const PlaneContact&) {
  return kNever;
}
double distance(const Vec3&, const PickedFaces&) {
  return kNever;
}

/// The boundary faces as regions see them.
class Surface {
 public:
  explicit Surface(const TetMesh& rest) : rest_(rest) {
    const Eigen::Index count = rest.boundary_faces.rows();
    area_normal_.resize(count, 3);
    centroid_.resize(count, 3);
    for (Eigen::Index f = 0; f < count; ++f) {
      const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
      area_normal_.row(f) = 0.5 * (b - a).cross(c - a).transpose();
      centroid_.row(f) = (a + b + c).transpose() / 3;
      box_.extend(a);
      box_.extend(b);
      box_.extend(c);
    }
    plate_ = plate_faces(rest);
  }

  Index count() const { return static_cast<Index>(centroid_.rows()); }
  Vec3 corner(Eigen::Index f, int i) const {
    return rest_.vertices.row(rest_.boundary_faces(f, i)).transpose();
  }
  Vec3 area_normal(Eigen::Index f) const { return area_normal_.row(f).transpose(); }
  Vec3 centroid(Eigen::Index f) const { return centroid_.row(f).transpose(); }
  const Eigen::AlignedBox3d& box() const { return box_; }

  /// How far a face is from belonging to a shape, mm: 0 or less for faces of it.
  double distance(Eigen::Index f, const PlateContact&) const {
    return plate_[static_cast<std::size_t>(f)] != 0 ? 0 : kNever;
  }
  double distance(Eigen::Index f, const PlaneContact& plane) const {
    const double tolerance = plane.tolerance.value_or(kContactTolerance * box_.diagonal().norm());
    if (area_normal(f).normalized().dot(plane.normal) < kContactCosine) return kNever;
    double farthest = 0;
    for (int i = 0; i < 3; ++i)
      farthest = std::max(farthest, std::abs((corner(f, i) - plane.point).dot(plane.normal)));
    return farthest - tolerance;
  }
  double distance(Eigen::Index f, const HalfSpace& half) const {
    return s3::distance(centroid(f), half);
  }
  double distance(Eigen::Index f, const BoxRegion& box) const {
    return s3::distance(centroid(f), box);
  }
  double distance(Eigen::Index f, const SphereRegion& sphere) const {
    return s3::distance(centroid(f), sphere);
  }

  /// Sets the flags of the faces nearest to the points, and of those that a face's angle reaches.
  void pick(const PickedFaces& picked, std::vector<char>& chosen) const {
    const AabbTree tree(rest_.vertices, rest_.boundary_faces);
    const std::vector<std::vector<Index>> beside =
        picked.angle > 0 ? neighbours() : std::vector<std::vector<Index>>{};
    for (const Vec3& point : *picked.points) {
      const Index seed = tree.closest(point).triangle;
      if (seed < 0) continue;
      chosen[static_cast<std::size_t>(seed)] = 1;
      if (picked.angle > 0) flood(seed, std::cos(picked.angle), beside, chosen);
    }
  }

 private:
  /// Faces that share an edge.
  std::vector<std::vector<Index>> neighbours() const {
    struct Side {
      Index a, b, face;
    };
    std::vector<Side> sides;
    for (Index f = 0; f < count(); ++f)
      for (int i = 0; i < 3; ++i) {
        const Index a = rest_.boundary_faces(f, i), b = rest_.boundary_faces(f, (i + 1) % 3);
        sides.push_back({std::min(a, b), std::max(a, b), f});
      }
    std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
      return std::array{p.a, p.b, p.face} < std::array{q.a, q.b, q.face};
    });
    std::vector<std::vector<Index>> beside(static_cast<std::size_t>(count()));
    for (std::size_t i = 1; i < sides.size(); ++i)
      if (sides[i].a == sides[i - 1].a && sides[i].b == sides[i - 1].b) {
        beside[static_cast<std::size_t>(sides[i].face)].push_back(sides[i - 1].face);
        beside[static_cast<std::size_t>(sides[i - 1].face)].push_back(sides[i].face);
      }
    return beside;
  }

  void flood(Index seed, double cosine, const std::vector<std::vector<Index>>& beside,
             std::vector<char>& chosen) const {
    const Vec3 normal = area_normal(seed).normalized();
    std::vector<char> seen(chosen.size(), 0);
    std::vector<Index> open = {seed};
    seen[static_cast<std::size_t>(seed)] = 1;
    while (!open.empty()) {
      const auto face = static_cast<std::size_t>(open.back());
      open.pop_back();
      chosen[face] = 1;
      for (const Index next : beside[face]) {
        if (seen[static_cast<std::size_t>(next)] != 0) continue;
        seen[static_cast<std::size_t>(next)] = 1;
        if (area_normal(next).normalized().dot(normal) >= cosine) open.push_back(next);
      }
    }
  }

  const TetMesh& rest_;
  Points area_normal_, centroid_;  // mm² times the outward normal; mm
  Eigen::AlignedBox3d box_;
  std::vector<char> plate_;
};

struct Nearest {
  double distance = kNever;
  Vec3 place = Vec3::Zero();
};

[[noreturn]] void empty_region(const Surface& surface, const std::string& name, Stage stage,
                               const Nearest& nearest) {
  std::string message = "The region " + name + " contains no face of the part, which stands from " +
                        text_of(surface.box().min()) + " to " + text_of(surface.box().max()) +
                        " mm";
  if (std::isfinite(nearest.distance))
    message.append("; the nearest face is ")
        .append(number(nearest.distance))
        .append(" mm away at ")
        .append(text_of(nearest.place));
  throw Error(
      ErrorKind::input, stage, std::string(stage_name(stage)) + ".empty_region", message + ".",
      "Regions count from the part as it stands on the plate (z up, plate at z = 0, after "
      "input.up, input.scale and input.rotate); move or widen the region, or turn its normal "
      "outward.",
      std::isfinite(nearest.distance) ? std::vector<Vec3>{nearest.place} : std::vector<Vec3>{});
}

struct Faces {
  std::vector<Index> found;  // ascending
  Nearest nearest;           // of those that were looked at
};

Faces faces_of(const Surface& surface, const Region& region) {
  std::vector<char> chosen(static_cast<std::size_t>(surface.count()), 0);
  Nearest nearest;
  for (const Shape& shape : region.shapes) {
    if (const auto* picked = std::get_if<PickedFaces>(&shape)) {
      surface.pick(*picked, chosen);
      continue;
    }
    for (Index f = 0; f < surface.count(); ++f) {
      const double distance = std::visit(
          [&](const auto& s) {
            if constexpr (std::is_same_v<std::decay_t<decltype(s)>, PickedFaces>)
              return kNever;
            else
              return surface.distance(f, s);
          },
          shape);
      if (distance <= 0) chosen[static_cast<std::size_t>(f)] = 1;
      if (distance < nearest.distance) nearest = {distance, surface.centroid(f)};
    }
  }
  std::vector<Index> faces;
  for (Index f = 0; f < surface.count(); ++f)
    if (chosen[static_cast<std::size_t>(f)] != 0) faces.push_back(f);
  return {std::move(faces), nearest};
}

std::vector<Index> some_faces_of(const Surface& surface, const Region& region, Stage stage) {
  Faces faces = faces_of(surface, region);
  if (faces.found.empty()) empty_region(surface, region.name, stage, faces.nearest);
  return std::move(faces.found);
}

/// One case, condition after condition.
class CaseBuilder {
 public:
  CaseBuilder(const TetMesh& rest, const Surface& surface, const LoadCases& file,
              const LoadCase& one, const std::vector<std::vector<Index>>& region_faces)
      : rest_(rest), surface_(surface), file_(file), case_(one), region_faces_(region_faces) {
    const auto vertices = static_cast<std::size_t>(rest.vertex_count());
    loading_.held.assign(vertices, 0);
    loading_.displacement = Points::Zero(rest.vertex_count(), 3);
    loading_.force = Points::Zero(rest.vertex_count(), 3);
    held_by_.assign(3 * vertices, 0);
  }

  Loading build() {
    for (const Condition& condition : case_.conditions)
      if (const auto* moved = std::get_if<Displacement>(&condition.action)) hold(condition, *moved);
    for (const Condition& condition : case_.conditions) load(condition);
    if (loading_.force.cwiseAbs().maxCoeff() == 0 &&
        loading_.displacement.cwiseAbs().maxCoeff() == 0)
      throw Error(ErrorKind::input, Stage::fea, "fea.no_load", "Nothing loads the part" + in_case(),
                  "Add a condition with force, pressure, gravity or displacement.");
    return std::move(loading_);
  }

 private:
  std::string in_case() const { return " in the load case \"" + case_.name + "\"."; }
  const Region& region(const Condition& condition) const { return file_.regions[condition.region]; }

  void hold(const Condition& condition, const Displacement& moved) {
    for (const Index f : region_faces_[condition.region])
      for (int i = 0; i < 3; ++i)
        for (int axis = 0; axis < 3; ++axis)
          if (const auto& value = moved.value[static_cast<std::size_t>(axis)])
            hold(rest_.boundary_faces(f, i), axis, *value, condition.region);
  }

  void hold(Index v, int axis, double value, std::size_t region) {
    double& stored = loading_.displacement(v, axis);
    std::size_t& by = held_by_[3 * static_cast<std::size_t>(v) + static_cast<std::size_t>(axis)];
    if ((loading_.held[v] >> axis & 1) != 0 && std::abs(stored - value) > kSameDisplacement)
      throw Error(ErrorKind::input, Stage::fea, "fea.contradictory",
                  "The regions " + file_.regions[by].name + " and " + file_.regions[region].name +
                      " share the vertex at " + text_of(rest_.vertices.row(v).transpose()) +
                      ", which one moves by " + number(stored) + " mm along " +
                      std::string(1, "xyz"[axis]) + " and the other by " + number(value) + " mm" +
                      in_case(),
                  "Let the regions keep apart by at least one face, or give them one displacement.",
                  {rest_.vertices.row(v).transpose()});
    loading_.held[v] = static_cast<std::uint8_t>(loading_.held[v] | 1 << axis);
    stored = value;
    by = region;
  }

  void load(const Condition& condition) {
    if (const auto* force = std::get_if<TotalForce>(&condition.action)) {
      double area = 0;
      for (const Index f : region_faces_[condition.region]) area += surface_.area_normal(f).norm();
      spread(condition,
             [&](Index f) { return Vec3(force->newton * surface_.area_normal(f).norm() / area); });
    } else if (const auto* pressure = std::get_if<Pressure>(&condition.action)) {
      spread(condition,
             [&](Index f) { return Vec3(-pressure->megapascal * surface_.area_normal(f)); });
    } else if (const auto* gravity = std::get_if<Gravity>(&condition.action)) {
      const Vec3 density = kGravityUnit * file_.material.density * gravity->acceleration;
      for (Index t = 0; t < rest_.tet_count(); ++t)
        for (int i = 0; i < 4; ++i)
          loading_.force.row(rest_.tets(t, i)) +=
              0.25 * tet_volume(rest_.vertices, rest_.tets, t) * density.transpose();
    }
  }

  /// A third of every face's force to each of its vertices. Something of it must be able to act.
  template <class FaceForce>
  void spread(const Condition& condition, FaceForce&& face_force) {
    bool acts = false, any = false;
    for (const Index f : region_faces_[condition.region]) {
      const Vec3 force = face_force(f);
      for (int i = 0; i < 3; ++i) {
        const Index v = rest_.boundary_faces(f, i);
        loading_.force.row(v) += force.transpose() / 3;
        for (int axis = 0; axis < 3; ++axis) {
          any = any || force[axis] != 0;
          acts = acts || (force[axis] != 0 && (loading_.held[v] >> axis & 1) == 0);
        }
      }
    }
    if (any && !acts)
      throw Error(ErrorKind::input, Stage::fea, "fea.contradictory",
                  "The load on the region " + region(condition).name +
                      " acts on held vertices only" + in_case(),
                  "Load another region, or free the axis along which the load acts.");
  }

  const TetMesh& rest_;
  const Surface& surface_;
  const LoadCases& file_;
  const LoadCase& case_;
  const std::vector<std::vector<Index>>& region_faces_;
  Loading loading_;
  std::vector<std::size_t> held_by_;  // 3·#V: the region that holds the axis
};

void check_held(const TetMesh& rest, const Loading& loading, const LoadCase& one) {
  const std::vector<std::string> motions = free_motions(rest, loading.held);
  if (motions.empty()) return;
  std::string list;
  for (std::size_t i = 0; i < motions.size(); ++i)
    list.append(i == 0 ? "" : i + 1 == motions.size() ? " and " : ", ").append(motions[i]);
  throw Error(
      ErrorKind::input, Stage::fea, "fea.unconstrained",
      "In the load case \"" + one.name + "\" the part is not held: it can still " + list + ".",
      "Fix a region against it, as {\"region\": \"plate\", \"fixed\": true}.");
}

}  // namespace

std::vector<Index> region_faces(const TetMesh& rest, const Region& region, Stage stage) {
  return some_faces_of(Surface(rest), region, stage);
}

std::vector<Index> region_tets(const TetMesh& rest, const Region& region) {
  const Surface surface(rest);
  const Faces faces = faces_of(surface, region);
  std::vector<char> chosen(static_cast<std::size_t>(rest.tet_count()), 0);
  for (const Index f : faces.found)
    chosen[static_cast<std::size_t>(rest.boundary_face_tet[static_cast<std::size_t>(f)])] = 1;
  std::vector<Index> tets;
  for (Index t = 0; t < rest.tet_count(); ++t) {
    const Vec3 centroid = rest.centroid(t);
    const bool inside =
        std::any_of(region.shapes.begin(), region.shapes.end(), [&](const Shape& shape) {
          return std::visit([&](const auto& s) { return distance(centroid, s) <= 0; }, shape);
        });
    if (inside || chosen[static_cast<std::size_t>(t)] != 0) tets.push_back(t);
  }
  if (tets.empty()) empty_region(surface, region.name, Stage::fea, faces.nearest);
  return tets;
}

std::vector<Loading> apply_load_cases(const TetMesh& rest, const LoadCases& file, Context& ctx) {
  const Surface surface(rest);
  std::vector<std::vector<Index>> faces;
  for (const Region& region : file.regions) {
    ctx.checkpoint();
    faces.push_back(some_faces_of(surface, region, Stage::fea));
  }
  std::vector<Loading> loadings;
  for (const LoadCase& one : file.cases) {
    ctx.checkpoint();
    loadings.push_back(CaseBuilder(rest, surface, file, one, faces).build());
    if (loadings.size() < 2 || loadings.back().held != loadings[loadings.size() - 2].held)
      check_held(rest, loadings.back(), one);
  }
  return loadings;
}

}  // namespace s3
