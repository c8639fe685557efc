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

TEST_CASE("the flood comes to a hanging prong over the pass that holds it") {
  Context ctx;
  const TetMesh hook = test::make_carved(24, 8, 40, Vec3(12, 4, 20), [](const Vec3& p) {
    return p.z() > 16 || p.x() < 4 || (p.x() > 8 && p.z() > 4);
  });
  const ObjectiveField objectives = make_objectives(hook, {}, nullptr);
  const FieldOperators operators(hook, ctx);
  const Values height = hook.vertices.col(2);
  const Flood flood = flood_from_plate(hook, operators, objectives, height, -2);
  for (Index v = 0; v < hook.vertex_count(); ++v) {
    if (!operators.in_use(v)) continue;
    const bool hangs = hook.vertices(v, 0) >= 8 && height(v) < 16;
    CHECK(flood.level(v) == doctest::Approx(hangs ? 16 : height(v)));
    // Each way ends on the plate, and never rises above its level.
    Index at = v;
    for (int step = 0; flood.from[at] >= 0; ++step, at = flood.from[at]) {
      REQUIRE(step < hook.vertex_count());
      CHECK(height(at) <= flood.level(v) + 1e-9);
    }
    CHECK(objectives.vertex_on_plate[at]);
  }
  // No way leads down into the prong where layers cannot follow it.
  const Flood gentle = flood_from_plate(hook, operators, objectives, height, 0);
  for (Index v = 0; v < hook.vertex_count(); ++v)
    if (operators.in_use(v) && hook.vertices(v, 0) >= 8 && height(v) < 16)
      CHECK(gentle.from[v] < 0);
}

TEST_CASE("shallow islands are drained by less than their depth, deep ones stay") {
  Context ctx;
  // A hook whose prong hangs 4 mm, and dents of 0.1 to 0.3 mm in the height.
  const TetMesh hook = test::make_carved(12, 8, 20, Vec3(12, 8, 20), [](const Vec3& p) {
    return p.z() > 16 || p.x() < 4 || (p.x() > 8 && p.z() > 12);
  });
  const ObjectiveField objectives = make_objectives(hook, {}, nullptr);
  const FieldOperators operators(hook, ctx);
  Values height = 0.2 * hook.vertices.col(2);
  for (Index v = 0; v < hook.vertex_count(); ++v)
    if (hook.vertices(v, 0) < 4 && hook.vertices(v, 2) > 2) height(v) -= 0.1 * (v % 7 % 4);
  const std::size_t before = find_islands(hook, objectives, height).size();
  CHECK(before > 5);
  const Values drained = drain_shallow_basins(hook, operators, objectives, height, 0.5, 1e-5);
  const std::vector<Island> left = find_islands(hook, objectives, drained);
  REQUIRE(left.size() == 1);
  CHECK(left[0].place.x() > 8);
  const Values raised = drained - height;
  CHECK(raised.minCoeff() == 0);
  CHECK(raised.maxCoeff() > 0);
  CHECK(raised.maxCoeff() < 0.5);
  CHECK(find_islands(hook, objectives,
                     drain_shallow_basins(hook, operators, objectives, height, 2, 1e-5))
            .empty());
}
