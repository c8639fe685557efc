#include "scalar_field/scalar_field.h"

namespace s3 {

ScalarField make_scalar_field(const TetMesh& rest, Values value) {
  ScalarField field{std::move(value), Points(rest.tet_count(), 3), Directions(rest.tet_count(), 3)};
  for (Index t = 0; t < rest.tet_count(); ++t) {
    const Eigen::Vector4d corners(field.value(rest.tets(t, 0)), field.value(rest.tets(t, 1)),
                                  field.value(rest.tets(t, 2)), field.value(rest.tets(t, 3)));
    const Vec3 gradient = hat_gradients(rest, t) * corners;
    const double length = gradient.norm();
    field.gradient.row(t) = gradient;
    field.print_direction.row(t) = length > 0 ? Vec3(gradient / length) : Vec3(Vec3::Zero());
  }
  return field;
}

}  // namespace s3
