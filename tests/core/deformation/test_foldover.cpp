#include "deformation/foldover.h"

#include <doctest/doctest.h>

#include "grid_mesh.h"

using namespace s3;

namespace {

std::vector<char> bottom(const TetMesh& mesh) {
  std::vector<char> on_plate(static_cast<std::size_t>(mesh.vertex_count()));
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    on_plate[static_cast<std::size_t>(v)] = mesh.vertices(v, 2) < 1e-9;
  return on_plate;
}

Index vertex_at(const TetMesh& mesh, const Vec3& place) {
  Eigen::Index v;
  (mesh.vertices.rowwise() - place.transpose()).rowwise().norm().minCoeff(&v);
  return static_cast<Index>(v);
}

// A fixed sequence of numbers in [-1, 1].
double noise(std::uint32_t& state) {
  state = state * 1664525u + 1013904223u;
  return (state >> 8) * (2.0 / (1 << 24)) - 1;
}

}  // namespace

TEST_CASE("a map without foldovers is left alone") {
  const TetMesh rest = test::make_grid(2, 2, 2, Vec3(2, 2, 2));
  Points deformed = rest.vertices * Vec3(1, 1, 0.5).asDiagonal();
  const Points before = deformed;
  Context ctx;
  CHECK(repair_foldovers(rest, bottom(rest), deformed, ctx).found == 0);
  CHECK(deformed == before);
}

TEST_CASE(
    "a vertex pushed through its neighbours is brought back, and only its surroundings move") {
  const TetMesh rest = test::make_grid(8, 8, 8, Vec3(8, 8, 8));
  Points deformed = rest.vertices;
  deformed.row(vertex_at(rest, Vec3(4, 4, 4))) += Eigen::RowVector3d(1.7, 0.4, -1.1);
  const Points before = deformed;
  Context ctx;
  const FoldoverReport report = repair_foldovers(rest, bottom(rest), deformed, ctx);
  CHECK(report.found > 0);
  CHECK(report.kept_share == 1);
  CHECK(volume_shares(rest, deformed).minCoeff() > kLeastVolumeShare);
  CHECK(ctx.warnings.empty());
  for (Index v = 0; v < rest.vertex_count(); ++v)
    if ((rest.vertices.row(v) - Eigen::RowVector3d(4, 4, 4)).norm() > 4)
      CHECK(deformed.row(v) == before.row(v));
}

TEST_CASE("a foldover on the plate is repaired with the plate at z = 0") {
  const TetMesh rest = test::make_grid(6, 6, 3, Vec3(6, 6, 3));
  Points deformed = rest.vertices;
  deformed.row(vertex_at(rest, Vec3(3, 3, 0))) += Eigen::RowVector3d(1.8, 0.2, 0);
  deformed.row(vertex_at(rest, Vec3(2, 3, 1))) += Eigen::RowVector3d(0, 0, -1.6);
  Context ctx;
  const FoldoverReport report = repair_foldovers(rest, bottom(rest), deformed, ctx);
  CHECK(report.found > 0);
  CHECK(report.kept_share == 1);
  CHECK(volume_shares(rest, deformed).minCoeff() > kLeastVolumeShare);
  for (Index v = 0; v < rest.vertex_count(); ++v)
    if (rest.vertices(v, 2) < 1e-9) CHECK(deformed(v, 2) == 0);
}

TEST_CASE("whatever the map, no tet is folded on exit") {
  const TetMesh rest = test::make_grid(4, 4, 4, Vec3(4, 4, 4));
  std::uint32_t state = 7;
  for (const double amplitude : {0.5, 1.0, 3.0}) {
    Points deformed = rest.vertices;
    for (Index v = 0; v < rest.vertex_count(); ++v)
      for (int k = 0; k < (rest.vertices(v, 2) > 0 ? 3 : 2); ++k)
        deformed(v, k) += amplitude * noise(state);
    Context ctx;
    const FoldoverReport report = repair_foldovers(rest, bottom(rest), deformed, ctx);
    CHECK(report.found > 0);
    CHECK(volume_shares(rest, deformed).minCoeff() > kLeastVolumeShare);
    CHECK(ctx.warnings.size() == (report.kept_share < 1 ? 1 : 0));
  }
}

TEST_CASE("a shape collapsed to a point, or mirrored, still ends without foldovers") {
  const TetMesh rest = test::make_grid(3, 3, 3, Vec3(3, 3, 3));
  for (const double factor : {0.0, -1.0}) {
    Points deformed = factor * rest.vertices;
    Context ctx;
    const FoldoverReport report = repair_foldovers(rest, bottom(rest), deformed, ctx);
    CHECK(report.found == rest.tet_count());
    CHECK(volume_shares(rest, deformed).minCoeff() > kLeastVolumeShare);
  }
}

TEST_CASE("a tet that lies on the plate with all four corners can be unfolded") {
  // Four vertices of the contact at slightly different heights, flattened to z = 0 by the plate.
  Points v(5, 3);
  v << 0, 0, 0, 2, 0, 0, 0, 2, 0, 0.5, 0.5, 0.01, 0.5, 0.5, 2;
  Tets t(4, 4);
  t << 0, 1, 2, 3, 0, 1, 3, 4, 1, 2, 3, 4, 2, 0, 3, 4;
  const TetMesh rest = make_tet_mesh(v, t);
  Points deformed = rest.vertices;
  deformed(3, 2) = 0;
  Context ctx;
  const FoldoverReport report = repair_foldovers(rest, {1, 1, 1, 1, 0}, deformed, ctx);
  CHECK(report.found == 1);
  CHECK(volume_shares(rest, deformed).minCoeff() > kLeastVolumeShare);
}
