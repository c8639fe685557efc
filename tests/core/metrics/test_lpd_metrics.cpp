#include "metrics/lpd_metrics.h"

#include <cmath>

#include <doctest/doctest.h>

#include "base/units.h"
#include "grid_mesh.h"
#include "metrics/support_volume.h"

namespace {

using s3::Directions;
using s3::Vec3;

s3::ObjectiveField objectives_of(const s3::TetMesh& mesh) {
  return s3::make_objectives(mesh, s3::ObjectiveParams{}, nullptr);
}

Directions constant(const s3::TetMesh& mesh, const Vec3& d) {
  return d.normalized().transpose().replicate(mesh.tet_count(), 1);
}

s3::Metrics metrics_of(const s3::TetMesh& mesh, const Directions& d) {
  s3::Metrics metrics;
  s3::lpd_metrics(s3::lpd_angles(mesh, objectives_of(mesh), nullptr, d), metrics);
  return metrics;
}

Vec3 tilted(double angle_deg) {
  return {std::sin(s3::radians(angle_deg)), 0, std::cos(s3::radians(angle_deg))};
}

}  // namespace

TEST_CASE("an upright box in planar layers needs no support and has the best surface") {
  const auto box = s3::test::make_grid(3, 3, 3, {10, 10, 10});
  const auto m = metrics_of(box, constant(box, Vec3::UnitZ()));
  CHECK(*m.support_free_area_percent == doctest::Approx(100));
  CHECK(*m.support_free_mean_violation_deg == 0);
  CHECK(*m.surface_quality_area_percent == doctest::Approx(100));
  CHECK_FALSE(m.strength_critical_percent.has_value());
}

TEST_CASE("tilted layers of a box: which walls overhang, and by how much") {
  // Five faces off the plate, 100 mm² each. Tilted by 60° towards +x the wall at -x faces 150° away
  // from d.
  const auto box = s3::test::make_grid(3, 3, 3, {10, 10, 10});
  const auto m = metrics_of(box, constant(box, tilted(60)));
  CHECK(*m.support_free_area_percent == doctest::Approx(80));
  CHECK(*m.support_free_mean_violation_deg == doctest::Approx((150 - 135) * 0.2));
  // Angles to ±n: top 60°, walls at ±x 30°, walls at ±y 90°.
  CHECK(*m.surface_quality_area_percent == doctest::Approx(40));
}

TEST_CASE("45 degrees exactly still prints, a hair more does not") {
  const auto box = s3::test::make_grid(2, 2, 2, {10, 10, 10});
  CHECK(*metrics_of(box, constant(box, tilted(45))).support_free_area_percent ==
        doctest::Approx(100));
  CHECK(*metrics_of(box, constant(box, tilted(45.001))).support_free_area_percent ==
        doctest::Approx(80));
}

TEST_CASE("a tet without a direction counts as the worst") {
  const auto box = s3::test::make_grid(1, 1, 1, {10, 10, 10});
  const auto m = metrics_of(box, Directions::Zero(box.tet_count(), 3));
  CHECK(*m.support_free_area_percent == 0);
  CHECK(*m.surface_quality_area_percent == 0);
}

TEST_CASE("critical tets count when the layer holds tau_max within 10 degrees") {
  const auto box = s3::test::make_grid(1, 1, 1, {10, 10, 10});
  s3::StressField stress;
  stress.critical_tets = {0, 1, 2, 3};
  stress.principal = Vec3::UnitX().transpose().replicate(6, 1);
  Directions d = constant(box, Vec3::UnitZ());  // holds
  d.row(1) = tilted(-9).transpose();            // holds, tilted away
  d.row(2) = tilted(11).transpose();            // does not
  d.row(4) = Vec3::UnitX().transpose();         // not critical
  s3::Metrics m;
  s3::lpd_metrics(s3::lpd_angles(box, objectives_of(box), &stress, d), m);
  CHECK(*m.strength_critical_percent == doctest::Approx(75));
}

TEST_CASE("folded tets are counted, flat ones too") {
  const auto box = s3::test::make_grid(1, 1, 1, {10, 10, 10});
  CHECK(s3::count_foldovers(box.vertices, box.tets) == 0);
  s3::Points flat = box.vertices;
  flat.col(2).setZero();
  CHECK(s3::count_foldovers(flat, box.tets) == 6);
  // Two tets on one face; the far corner of the second is pushed through it.
  s3::Points two(5, 3);
  two << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1;
  s3::Tets tets(2, 4);
  tets << 0, 1, 2, 3, 1, 2, 3, 4;
  const auto mesh = s3::make_tet_mesh(two, tets);
  two.row(4) << 0.1, 0.1, 0.1;
  CHECK(s3::count_foldovers(two, mesh.tets) == 1);
}

TEST_CASE("support volume under a T: the space below its arms") {
  // A block over 0..30 x 0..10 x 0..20, squeezed below z = 10 to the width 10..20: arms of 10 x 10
  // on both sides, with slanted undersides over 0.5 mm of height, far beyond 45°.
  const auto bend = [](const Vec3& p) -> Vec3 {
    return p.z() < 10 ? Vec3(10 + p.x() / 3, p.y(), p.z()) : p;
  };
  s3::Points vertices;
  const auto shape = [&](const Vec3& p) -> Vec3 {
    // Grid heights 0, 5, 10, 15, 20; the one at 10 belongs to the arms, the one at 5 moves up
    // to 9.5.
    const Vec3 q = bend(p);
    return p.z() == 5 ? Vec3(q.x(), q.y(), 9.5) : q;
  };
  const auto mesh = s3::test::make_grid(6, 2, 4, {30, 10, 20}, shape);
  s3::Context ctx;
  const double volume =
      s3::support_volume(mesh, objectives_of(mesh), constant(mesh, Vec3::UnitZ()), ctx);
  // Under each arm a prism: from (0, 10) to (10, 9.5) above the plate, 10 deep: 975 mm³.
  CHECK(volume == doctest::Approx(2 * 975).epsilon(0.002));
  // Layers that stand upright (d = y) hang over at the walls at -y alone, and a wall has no space
  // below it.
  CHECK(s3::support_volume(mesh, objectives_of(mesh), constant(mesh, {0, 1, 0}), ctx) == 0);
}
