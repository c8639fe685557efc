#include "mesh/repair.h"

#include <doctest/doctest.h>

#include "base/error.h"
#include "mesh/defective_meshes.h"
#include "mesh/repair_parts.h"

using namespace s3;

namespace {

bool has_change(const RepairResult& result, const std::string& code) {
  return std::any_of(result.changes.begin(), result.changes.end(),
                     [&](const RepairChange& c) { return c.code == code; });
}

}  // namespace

TEST_CASE("every kind of defect ends in a valid surface, a rebuild or one clear sentence") {
  const auto meshes = test::defective_meshes();
  CHECK(meshes.size() >= 40);
  for (const test::DefectiveMesh& defective : meshes) {
    CAPTURE(defective.name);
    Context ctx;
    try {
      const RepairResult result = repair_surface(defective.mesh, ctx);
      REQUIRE(defective.outcome != test::Outcome::error);
      CAPTURE(result.reason);
      CHECK(result.valid == (defective.outcome == test::Outcome::valid));
      CHECK(result.valid == result.reason.empty());
      if (!defective.code.empty()) CHECK(has_change(result, defective.code));
      if (defective.volume > 0) {
        CHECK(enclosed_volume(result.surface) == doctest::Approx(defective.volume).epsilon(0.01));
        CHECK(result.report.open_edges.count == 0);
      }
      for (const RepairChange& change : result.changes) CHECK(change.count > 0);
    } catch (const Error& e) {
      CAPTURE(std::string(e.what()));
      REQUIRE(defective.outcome == test::Outcome::error);
      CHECK(e.kind == ErrorKind::input);
      CHECK(e.code == defective.code);
      CHECK(!e.hint.empty());
    }
  }
}

namespace {

// Numbers for the triangles of meshes that were joined.
std::vector<Index> parts_of(std::initializer_list<const TriMesh*> meshes) {
  std::vector<Index> parts;
  Index part = 0;
  for (const TriMesh* mesh : meshes)
    parts.insert(parts.end(), static_cast<std::size_t>(mesh->triangles.rows()), part++);
  return parts;
}

}  // namespace

TEST_CASE("a closed shell inside another is a cavity in one part, a body in two") {
  const TriMesh outer = test::box_surface(Vec3::Constant(10)),
                inner = test::box_surface(Vec3::Constant(4), Vec3::Constant(3));
  const TriMesh both = test::joined(outer, inner);
  Context ctx;
  const RepairResult one_part = repair_surface(both, ctx);
  CHECK(one_part.valid);
  CHECK(one_part.report.volume == doctest::Approx(1000 - 64));
  REQUIRE(ctx.warnings.size() == 1);
  CHECK(ctx.warnings[0].code == "mesh.nested_body");

  ctx.warnings.clear();
  const RepairResult two_parts = repair_parts(both, parts_of({&outer, &inner}), ctx);
  CHECK(!two_parts.valid);
  CHECK(two_parts.reason == "a part lies inside another");
  CHECK(enclosed_volume(two_parts.surface) == doctest::Approx(1064));  // both face outward
  CHECK(ctx.warnings.empty());
}

TEST_CASE("parts are repaired one by one, groups of one surface together") {
  Context ctx;
  const TriMesh a = test::box_surface(Vec3::Constant(10)),
                holed =
                    test::without_every(test::box_surface(Vec3::Constant(5), Vec3(20, 0, 0)), 9);
  RepairResult result = repair_parts(test::joined(a, holed), parts_of({&a, &holed}), ctx);
  CHECK(result.valid);
  CHECK(result.report.volume == doctest::Approx(1125));

  const auto low = [](const Vec3& p) { return p.z() < 5; };
  const TriMesh bottom = test::without(a, [&](const Vec3&p) { return !low(p); }),
                top = test::without(a, low);
  result = repair_parts(test::joined(bottom, top), parts_of({&bottom, &top}), ctx);
  CHECK(result.valid);
  CHECK(result.report.volume == doctest::Approx(1000));
  CHECK(!has_change(result, "repair.holes_flat"));

  const TriMesh beside = test::box_surface(Vec3::Constant(10), Vec3(10, 0, 0)),
                across = test::box_surface(Vec3::Constant(10), Vec3(5, 5, 5));
  result = repair_parts(test::joined(a, beside), parts_of({&a, &beside}), ctx);
  CHECK(result.valid);
  CHECK(result.report.shells.size() == 1);
  CHECK(result.report.volume == doctest::Approx(2000));
  result = repair_parts(test::joined(a, across), parts_of({&a, &across}), ctx);
  CHECK(!result.valid);

  const TriMesh sheet = test::without(a, [](const Vec3& p) { return p.z() > 1e-9; });
  result = repair_parts(test::joined(beside, sheet), parts_of({&beside, &sheet}), ctx);
  CHECK(result.valid);
  CHECK(result.report.volume == doctest::Approx(1000));
  CHECK(has_change(result, "repair.flat_parts"));
}

TEST_CASE("a change names its places, and a sound surface comes back as it was") {
  Context ctx;
  const TriMesh ball = test::ball_surface(10);
  RepairResult result = repair_surface(ball, ctx);
  CHECK(result.changes.empty());
  CHECK(result.surface.vertices == ball.vertices);
  CHECK(result.surface.triangles == ball.triangles);

  Index last = static_cast<Index>(ball.triangles.rows()) - 1;
  const Vec3 gone = test::middle_of(ball, last);
  TriMesh holed = ball;
  holed.triangles.conservativeResize(last, 3);
  result = repair_surface(holed, ctx);
  REQUIRE(result.changes.size() == 1);
  REQUIRE(result.changes[0].places.size() == 1);
  CHECK((result.changes[0].places[0] - gone).norm() < 1e-9);
}

TEST_CASE("repair does the same at every scale and place") {
  for (const double scale : {1e-4, 1.0, 1e4})
    for (const test::DefectiveMesh& defective : test::defective_meshes()) {
      if (defective.outcome == test::Outcome::error || defective.code == "repair.wild_coordinates")
        continue;
      CAPTURE(defective.name);
      CAPTURE(scale);
      TriMesh mesh = defective.mesh;
      mesh.vertices *= scale;
      Context ctx;
      const RepairResult result = repair_surface(mesh, ctx);
      CHECK(result.valid == (defective.outcome == test::Outcome::valid));
      if (defective.volume > 0)
        CHECK(enclosed_volume(result.surface) ==
              doctest::Approx(defective.volume * scale * scale * scale).epsilon(0.01));
    }
}
