#include "deformation/scale_controlled.h"

#include <doctest/doctest.h>

#include "base/units.h"
#include "grid_mesh.h"
#include "quaternion_field/rotations_from_deformation.h"

using namespace s3;

namespace {

std::vector<char> bottom(const TetMesh& mesh) {
  std::vector<char> on_plate(static_cast<std::size_t>(mesh.vertex_count()));
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    on_plate[static_cast<std::size_t>(v)] = mesh.vertices(v, 2) < 1e-9;
  return on_plate;
}

Quats rotated_about_y(const TetMesh& mesh, const std::function<double(const Vec3&)>& angle) {
  Quats q(mesh.tet_count(), 4);
  for (Index t = 0; t < mesh.tet_count(); ++t)
    q.row(t) = Quat(Eigen::AngleAxisd(angle(mesh.centroid(t)), Vec3::UnitY())).coeffs();
  return q;
}

// Eq. 12 in the units of the implementation, from its definition.
double energy(const TetMesh& rest, const Quats& rotation, const ScaleControlParams& params,
              const Points& vertices, const Points& scales) {
  const double h = mean_edge_length(rest), mean_volume = tet_volumes(rest).mean();
  const auto share = [&](Index t) { return tet_volume(rest.vertices, rest.tets, t) / mean_volume; };
  double sum = 0;
  for (Index t = 0; t < rest.tet_count(); ++t) {
    const Mat3 R =
        Quat(rotation(t, 3), rotation(t, 0), rotation(t, 1), rotation(t, 2)).toRotationMatrix();
    const Vec3 s = scales.row(t);
    Vec3 centre = Vec3::Zero();
    for (int i = 0; i < 4; ++i) centre += 0.25 * vertices.row(rest.tets(t, i)).transpose();
    for (int i = 0; i < 4; ++i) {
      const Vec3 placed = vertices.row(rest.tets(t, i)).transpose() - centre;
      const Vec3 wanted = R * s.cwiseProduct(rest.corner(t, i) - rest.centroid(t));
      sum += std::cbrt(share(t)) * (placed - wanted).squaredNorm() / (h * h);
    }
    sum += params.rigidity * share(t) * (s - Vec3::Ones()).squaredNorm();
  }
  const double resolution = std::pow(rest.tet_count() / 50000.0, 2.0 / 3.0);
  for (Eigen::Index p = 0; p < rest.face_pairs.rows(); ++p) {
    const Index i = rest.face_pairs(p, 0), j = rest.face_pairs(p, 1);
    sum += params.scale_compatibility * resolution * std::pow(share(i) * share(j), 1.0 / 6) *
           (scales.row(i) - scales.row(j)).squaredNorm();
  }
  return sum;
}

TetMesh uneven_block() {
  return test::make_grid(3, 3, 4, Vec3(6, 5, 9), [](const Vec3& p) {
    return Vec3(p.x() + 0.1 * p.z() * p.z() / 9, p.y() * (1 + 0.05 * p.x()),
                p.z() + 0.2 * p.x() * p.z() / 6);
  });
}

double bend(const Vec3& p) {
  return 0.05 * p.x() + 0.02 * p.z();
}

}  // namespace

TEST_CASE("without rotation nothing moves") {
  const TetMesh rest = uneven_block();
  Context ctx;
  const ScaleControlledDeformer deformer(rest, bottom(rest), {}, ctx);
  const Deformation d =
      deformer.deform(identity_rotations(rest.tet_count()), undeformed(rest), ctx);
  CHECK(d.converged);
  CHECK((d.vertices - rest.vertices).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((d.scales.array() - 1).abs().maxCoeff() < 1e-9);
}

TEST_CASE("a turn about z is followed exactly, on the plate too") {
  const TetMesh rest = uneven_block();
  Context ctx;
  Quats q(rest.tet_count(), 4);
  const Quat turn(Eigen::AngleAxisd(0.8, Vec3::UnitZ()));
  for (Index t = 0; t < rest.tet_count(); ++t) q.row(t) = turn.coeffs();
  const ScaleControlledDeformer deformer(rest, bottom(rest), {.tolerance = 1e-10}, ctx);
  const Deformation d = deformer.deform(q, undeformed(rest), ctx);
  const Points turned = rest.vertices * turn.toRotationMatrix().transpose();
  const Points difference = d.vertices - turned;
  CHECK((difference.rowwise() - difference.row(0)).cwiseAbs().maxCoeff() < 1e-6);
  CHECK(difference.col(2).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("the result is the minimum of Eq. 12 with the plate held") {
  const TetMesh rest = uneven_block();
  const ScaleControlParams params{.rigidity = 0.5, .scale_compatibility = 2000, .tolerance = 1e-10};
  const std::vector<char> on_plate = bottom(rest);
  const Quats q = rotated_about_y(rest, bend);
  Context ctx;
  const ScaleControlledDeformer deformer(rest, on_plate, params, ctx);
  const Deformation d = deformer.deform(q, undeformed(rest), ctx);
  CHECK(d.converged);
  const double least = energy(rest, q, params, d.vertices, d.scales);
  CHECK(least < energy(rest, q, params, rest.vertices, Points::Ones(rest.tet_count(), 3)));
  // Central differences along each kind of unknown vanish; on the plate, z may pull.
  const double step = 1e-4;
  const auto slope = [&](auto&& change) {
    Points x = d.vertices, s = d.scales;
    change(x, s, step);
    const double up = energy(rest, q, params, x, s);
    change(x, s, -2 * step);
    return (up - energy(rest, q, params, x, s)) / (2 * step);
  };
  for (Index v = 0; v < rest.vertex_count(); v += 5)
    for (int k = 0; k < 3; ++k) {
      const double g = slope([&](Points& x, Points&, double h) { x(v, k) += h; });
      if (k < 2 || !on_plate[static_cast<std::size_t>(v)]) CHECK(std::abs(g) < 1e-6);
    }
  for (Index t = 0; t < rest.tet_count(); t += 7)
    for (int k = 0; k < 3; ++k)
      CHECK(std::abs(slope([&](Points&, Points& s, double h) { s(t, k) += h; })) < 1e-6);
}

TEST_CASE("the plate contact stays at z = 0 and a warm start needs no iteration") {
  const TetMesh rest = uneven_block();
  const std::vector<char> on_plate = bottom(rest);
  const Quats q = rotated_about_y(rest, bend);
  Context ctx;
  const ScaleControlledDeformer deformer(rest, on_plate, {}, ctx);
  const Deformation d = deformer.deform(q, undeformed(rest), ctx);
  for (Index v = 0; v < rest.vertex_count(); ++v)
    if (on_plate[static_cast<std::size_t>(v)]) CHECK(d.vertices(v, 2) == 0);
  CHECK(d.iterations > 0);
  CHECK(deformer.deform(q, d, ctx).iterations == 0);
}

TEST_CASE("a model ten times as large gives a deformation ten times as large") {
  const TetMesh rest = uneven_block();
  const TetMesh large = make_tet_mesh(10 * rest.vertices, rest.tets);
  const Quats q = rotated_about_y(rest, bend);
  Context ctx;
  const auto solve = [&](const TetMesh& mesh) {
    const ScaleControlledDeformer deformer(mesh, bottom(rest), {}, ctx);
    return deformer.deform(q, undeformed(mesh), ctx);
  };
  const Deformation small = solve(rest), big = solve(large);
  CHECK((big.vertices - 10 * small.vertices).cwiseAbs().maxCoeff() < 1e-8);
  CHECK((big.scales - small.scales).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("a component that does not touch the plate is held where it is") {
  const TetMesh block = uneven_block();
  Points vertices(2 * block.vertex_count(), 3);
  vertices << block.vertices, block.vertices.rowwise() + Eigen::RowVector3d(20, 0, 3);
  Tets tets(2 * block.tet_count(), 4);
  tets << block.tets, block.tets.array() + block.vertex_count();
  const TetMesh both = make_tet_mesh(vertices, tets);
  Context ctx;
  const ScaleControlledDeformer deformer(both, bottom(both), {.tolerance = 1e-9}, ctx);
  const Quats q = rotated_about_y(both, [](const Vec3&) { return 0.3; });
  const Deformation d = deformer.deform(q, undeformed(both), ctx);
  CHECK(d.converged);
  // Without a plate the component turns as a rigid body about its lowest vertex.
  const Index held = block.vertex_count();
  const Mat3 turn = Eigen::AngleAxisd(0.3, Vec3::UnitY()).toRotationMatrix();
  for (Index v = held; v < both.vertex_count(); v += 11) {
    const Vec3 arm = (both.vertices.row(v) - both.vertices.row(held)).transpose();
    const Vec3 expected = both.vertices.row(held).transpose() + turn * arm;
    CHECK((Vec3(d.vertices.row(v)) - expected).norm() < 1e-5);
  }
}
