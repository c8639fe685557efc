#include "mesh/repair.h"

#include <doctest/doctest.h>

#include "base/error.h"
#include "mesh/defective_meshes.h"

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
