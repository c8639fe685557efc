#include <doctest/doctest.h>

#include <algorithm>

#include "carved_mesh.h"
#include "scalar_field/islands.h"

using namespace s3;

namespace {

std::vector<Island> planar_islands(const TetMesh& mesh) {
  return find_islands(mesh, make_objectives(mesh, {}, nullptr), mesh.vertices.col(2));
}

}  // namespace

TEST_CASE("a block on the plate has no island, nor has a gate on two legs") {
  CHECK(planar_islands(test::make_grid(3, 3, 3, Vec3(3, 3, 3))).empty());
  CHECK(planar_islands(test::make_carved(6, 2, 6, Vec3(6, 2, 6), [](const Vec3& p) {
          return p.z() > 4 || p.x() < 2 || p.x() > 4;
        })).empty());
}

TEST_CASE("a hook's flat tip is one island with the volume of what hangs") {
  // A post, a beam from z = 16 on, and a prong of 4 × 4 mm that hangs down to z = 4.
  const TetMesh hook = test::make_carved(24, 8, 40, Vec3(12, 4, 20), [](const Vec3& p) {
    return p.z() > 16 || p.x() < 4 || (p.x() > 8 && p.z() > 4);
  });
  const std::vector<Island> islands = planar_islands(hook);
  REQUIRE(islands.size() == 1);
  CHECK((islands[0].place - Vec3(10, 2, 4)).norm() < 0.3);
  // Up to z = 16 the prong is alone. A vertex stands for the tets around it: half a layer of 0.5 mm
  // of doubt.
  CHECK(islands[0].volume == doctest::Approx(4 * 4 * 12).epsilon(0.5 * 0.5 / 12 + 0.02));
}

TEST_CASE("two prongs that meet in the air are two islands, the later one ends where they meet") {
  // Prongs down to z = 2 (left) and z = 4 (right), joined at z = 8, and to the post at z = 12.
  const TetMesh fork = test::make_carved(14, 2, 14, Vec3(14, 2, 14), [](const Vec3& p) {
    if (p.x() < 2) return true;
    if (p.z() > 12) return true;
    if (p.x() < 4) return false;
    if (p.z() > 8) return true;
    return (p.x() < 6 && p.z() > 2) || (p.x() > 12 && p.z() > 4);
  });
  const std::vector<Island> islands = planar_islands(fork);
  REQUIRE(islands.size() == 2);
  CHECK(islands[0].place.z() == doctest::Approx(4));
  CHECK(islands[1].place.z() == doctest::Approx(2));
  CHECK(islands[0].volume < islands[1].volume);
  // left prong 2·2·6, right prong 2·2·4, bridge 10·2·4
  CHECK(islands[1].volume == doctest::Approx(24 + 16 + 80).epsilon(0.12));
}

TEST_CASE("the quick search finds the same islands as the sweep") {
  Context ctx;
  const TetMesh fork = test::make_carved(14, 2, 14, Vec3(14, 2, 14), [](const Vec3& p) {
    if (p.x() < 2 || p.z() > 12) return true;
    return (p.x() > 4 && p.x() < 6 && p.z() > 2) || (p.x() > 8 && p.x() < 10 && p.z() > 5) ||
           (p.x() > 12 && p.z() > 4);
  });
  const ObjectiveField objectives = make_objectives(fork, {}, nullptr);
  const FieldOperators operators(fork, ctx);
  for (const double slope : {0.0, 0.1, -0.4}) {
    const Values height = fork.vertices.col(2) + slope * fork.vertices.col(0);
    const auto minima = find_minima(fork, operators, objectives, height);
    std::vector<Vec3> places;
    for (const std::vector<Index>& minimum : minima) {
      Vec3 sum = Vec3::Zero();
      for (const Index v : minimum) sum += fork.vertices.row(v).transpose();
      places.push_back(sum / static_cast<double>(minimum.size()));
    }
    const std::vector<Island> islands = find_islands(fork, objectives, height);
    REQUIRE(islands.size() == places.size());
    CHECK(islands.size() >= 3);
    for (const Island& island : islands)
      CHECK(std::any_of(places.begin(), places.end(),
                        [&](const Vec3& p) { return (p - island.place).norm() < 1e-9; }));
  }
}

TEST_CASE("noise below the tolerance does not split a flat underside") {
  const TetMesh hook = test::make_carved(6, 2, 10, Vec3(6, 2, 10), [](const Vec3& p) {
    return p.z() > 8 || p.x() < 2 || (p.x() > 4 && p.z() > 2);
  });
  Values height = hook.vertices.col(2);
  for (Index v = 0; v < hook.vertex_count(); ++v) height(v) += 1e-12 * (v % 7);
  CHECK(find_islands(hook, make_objectives(hook, {}, nullptr), height).size() == 1);
}
