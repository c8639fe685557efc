#include "mesh/placement.h"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/units.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

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
                    "Write degrees about x, y and z, such as 90,0,45, or flat, or auto");
    angles[i] = radians(*angle);
    rest.remove_prefix(more ? comma + 1 : rest.size());
  }
  return (Eigen::AngleAxisd(angles[2], Vec3::UnitZ()) *
          Eigen::AngleAxisd(angles[1], Vec3::UnitY()) * Eigen::AngleAxisd(angles[0], Vec3::UnitX()))
      .toRotationMatrix();
}

// @throws Error "mesh.no_flat_face"
std::vector<Orientation> searched(const Points& vertices, const Triangles& surface,
                                  const std::string& rotate, const Context* ctx) {
  const auto goal = rotate == "flat" ? OrientationGoal::flat_face : OrientationGoal::least_support;
  std::vector<Orientation> found = rank_orientations(vertices, surface, goal, 5, ctx);
  if (found.empty())
    throw Error(ErrorKind::input, Stage::mesh, "mesh.no_flat_face",
                "The model has no flat face that it could lie on",
                "Set input.rotate to auto, or to degrees about x, y and z");
  return found;
}

}  // namespace

Eigen::Affine3d placement(const Points& vertices, const Triangles& surface,
                          const InputParams& params, std::vector<Orientation>* orientations,
                          const Context* ctx) {
  if (orientations) orientations->clear();
  if (params.up != "z" && params.up != "y")
    bad_placement("The up axis '" + params.up + "' is neither y nor z", "Set input.up to y or z");
  if (!(params.scale > 0) || !std::isfinite(params.scale))
    bad_placement("The scale " + std::to_string(params.scale) + " is not positive",
                  "Set input.scale to a positive factor, such as 25.4 for inches");
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  Mat3 z_up = Mat3::Identity();
  if (params.up == "y") z_up << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // (x, y, z) → (x, −z, y)
  transform.linear() = params.scale * z_up;
  std::string rotate = params.rotate;
  if (rotate == "auto" || rotate == "flat") {
    Points turned = vertices;
    transform_points(transform, turned);
    std::vector<Orientation> found = searched(turned, surface, rotate, ctx);
    rotate = found.front().rotate;  // what a user would write, so that writing it does the same
    if (orientations) *orientations = std::move(found);
  }
  transform.linear() = rotation_from_text(rotate) * transform.linear();
  const Eigen::RowVector3d row_z = transform.linear().row(2);
  transform.translation().z() = -(vertices * row_z.transpose()).minCoeff();
  return transform;
}

void transform_points(const Eigen::Affine3d& transform, Points& points) {
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    points.row(v) = transform * Vec3(points.row(v).transpose());
}

}  // namespace s3
