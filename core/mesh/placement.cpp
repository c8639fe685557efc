#include "mesh/placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/error.h"
#include "base/units.h"
#include "mesh/text_scanner.h"
#include "mesh/tri_mesh.h"

namespace s3 {

namespace {

constexpr std::size_t kFlatCandidates = 60;
constexpr int kSphereCandidates = 200;
constexpr double kFlatBins = 30;        // cells per unit of a normal's coordinates: about 2°
constexpr double kContactAngle = 1e-3;  // n = −z within this, and the face is near the bottom …
constexpr double kContactHeight = 1e-3;  // … within this part of the height
constexpr double kEqualArea = 2e-3;  // areas are told apart in steps of this part of the surface

[[noreturn]] void bad_placement(const std::string& what, const std::string& hint) {
  throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_placement", what, hint);
}

Mat3 rotation_from_text(const std::string& text) {
  std::array<double, 3> angles{};
  std::string_view rest = text;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t comma = rest.find(',');
    std::string_view part = rest.substr(0, comma);
    const std::optional<double> angle = parse_double(take_word(part));
    const bool more = comma != std::string_view::npos;
    if (!angle || !take_word(part).empty() || more != (i < 2))
      bad_placement("The rotation '" + text + "' is not three angles",
                    "Write degrees about x, y and z, such as 90,0,45, or auto");
    angles[i] = radians(*angle);
    rest.remove_prefix(more ? comma + 1 : rest.size());
  }
  return (Eigen::AngleAxisd(angles[2], Vec3::UnitZ()) *
          Eigen::AngleAxisd(angles[1], Vec3::UnitY()) * Eigen::AngleAxisd(angles[0], Vec3::UnitX()))
      .toRotationMatrix();
}

// The least rotation that makes `up` point along z.
Mat3 rotation_to_z(const Vec3& up) {
  if (up.z() < -1 + 1e-12) return Vec3(1, -1, -1).asDiagonal();  // half a turn about x
  return Quat::FromTwoVectors(up, Vec3::UnitZ()).toRotationMatrix();
}

struct Surface {
  const Points& vertices;
  const Triangles& triangles;
  Directions normals;  // unit
  std::vector<double> areas;
  double total_area = 0;
};

Surface measured(const Points& vertices, const Triangles& triangles) {
  Surface s{vertices, triangles, Directions(triangles.rows(), 3), {}, 0};
  s.areas.resize(static_cast<std::size_t>(triangles.rows()));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vec3 n = triangle_normal_2a(vertices, triangles.row(f));
    const double length = n.norm();
    s.normals.row(f) = length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
    s.areas[static_cast<std::size_t>(f)] = 0.5 * length;
    s.total_area += 0.5 * length;
  }
  return s;
}

struct Score {
  long overhang = 0, contact = 0;  // in steps of kEqualArea
  double height = 0;

  bool better_than(const Score& o) const {
    if (overhang != o.overhang) return overhang < o.overhang;
    if (contact != o.contact) return contact > o.contact;
    return height < o.height * (1 - 1e-6);
  }
};

Score score_of(const Surface& s, const Vec3& up, Eigen::VectorXd& heights) {
  heights.noalias() = s.vertices * up;
  const double low = heights.minCoeff(), height = heights.maxCoeff() - low;
  const double limit = low + kContactHeight * height;
  double overhang = 0, contact = 0;
  for (Eigen::Index f = 0; f < s.triangles.rows(); ++f) {
    const double nz = s.normals.row(f).dot(up);
    if (nz >= -std::sqrt(0.5)) continue;
    const double area = s.areas[static_cast<std::size_t>(f)];
    const bool low_face = heights[s.triangles(f, 0)] <= limit &&
                          heights[s.triangles(f, 1)] <= limit &&
                          heights[s.triangles(f, 2)] <= limit;
    // cos(1e-3) = 1 − 5e-7
    (low_face && nz < -1 + 0.5 * kContactAngle * kContactAngle ? contact : overhang) += area;
  }
  const double step = kEqualArea * s.total_area;
  return {std::lround(overhang / step), std::lround(contact / step), height};
}

// Unit normals of the regions of nearly equal normal, largest area first.
std::vector<Vec3> flat_normals(const Surface& s) {
  struct Cell {
    std::array<int, 3> key;
    Eigen::Index face;
  };
  std::vector<Cell> cells;
  for (Eigen::Index f = 0; f < s.triangles.rows(); ++f) {
    std::array<int, 3> key;
    for (int k = 0; k < 3; ++k)
      key[static_cast<std::size_t>(k)] = static_cast<int>(std::lround(s.normals(f, k) * kFlatBins));
    cells.push_back({key, f});
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return a.key != b.key ? a.key < b.key : a.face < b.face;
  });
  std::vector<Vec3> sums;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].key != cells[i - 1].key) sums.push_back(Vec3::Zero());
    sums.back() +=
        s.areas[static_cast<std::size_t>(cells[i].face)] * s.normals.row(cells[i].face).transpose();
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
Vec3 sphere_point(int i) {
  const double z = 1 - (2.0 * i + 1) / kSphereCandidates;
  const double angle = i * kPi * (3 - std::sqrt(5.0));
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace

Vec3 best_up_direction(const Points& vertices, const Triangles& triangles) {
  const Surface s = measured(vertices, triangles);
  Vec3 best = Vec3::UnitZ();
  if (!(s.total_area > 0)) return best;
  Eigen::VectorXd heights;
  Score best_score = score_of(s, best, heights);
  const auto consider = [&](const Vec3& up) {
    const Score score = score_of(s, up, heights);
    if (!score.better_than(best_score)) return;
    best = up;
    best_score = score;
  };
  for (const Vec3& normal : flat_normals(s)) consider(-normal);
  for (int i = 0; i < kSphereCandidates; ++i) consider(sphere_point(i));
  for (double step = radians(8); step > radians(0.5); step /= 2) {
    // A copy: `best` moves while its surroundings are searched.
    const Vec3 center = best;  // NOLINT(performance-unnecessary-copy-initialization)
    const Vec3 u = center.unitOrthogonal(), v = center.cross(u);
    for (int k = 0; k < 8; ++k) {
      const double angle = k * kPi / 4;
      consider(
          (center + std::tan(step) * (std::cos(angle) * u + std::sin(angle) * v)).normalized());
    }
  }
  return best;
}

Eigen::Affine3d placement(const Points& vertices, const Triangles& surface,
                          const InputParams& params) {
  if (params.up != "z" && params.up != "y")
    bad_placement("The up axis '" + params.up + "' is neither y nor z", "Set input.up to y or z");
  if (!(params.scale > 0) || !std::isfinite(params.scale))
    bad_placement("The scale " + std::to_string(params.scale) + " is not positive",
                  "Set input.scale to a positive factor, such as 25.4 for inches");
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  Mat3 z_up = Mat3::Identity();
  if (params.up == "y") z_up << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // (x, y, z) → (x, −z, y)
  transform.linear() = params.scale * z_up;
  if (params.rotate == "auto") {
    Points turned = vertices;
    transform_points(transform, turned);
    transform.linear() = rotation_to_z(best_up_direction(turned, surface)) * transform.linear();
  } else {
    transform.linear() = rotation_from_text(params.rotate) * transform.linear();
  }
  const Eigen::RowVector3d row_z = transform.linear().row(2);
  transform.translation().z() = -(vertices * row_z.transpose()).minCoeff();
  return transform;
}

void transform_points(const Eigen::Affine3d& transform, Points& points) {
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    points.row(v) = transform * Vec3(points.row(v).transpose());
}

}  // namespace s3
