#include "pipeline/pipeline.h"

#include <algorithm>
#include <map>
#include <span>

#include <doctest/doctest.h>

#include "base/error.h"
#include "grid_mesh.h"
#include "mesh/write_mesh.h"
#include "pipeline/outputs.h"

namespace {

using s3::Stage;
using s3::StageState;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// A block that leans over by 50°: small, quick, and something to do for SF.
std::string leaning_block() {
  const auto mesh = s3::test::make_grid(4, 3, 5, {8, 6, 10}, [](const s3::Vec3& p) -> s3::Vec3 {
    return {p.x() + 1.2 * std::max(0.0, p.z() - 2), p.y(), p.z()};
  });
  return s3::write_tet(mesh.vertices, mesh.tets);
}

s3::MachineProfile machine() {
  return s3::bundled_machine(s3::MachineParams{}.machine);
}

s3::Pipeline ready_pipeline() {
  s3::Pipeline pipeline;
  pipeline.set_params(s3::Params{}, machine());
  pipeline.set_model(bytes_of(leaning_block()), "block.tet");
  return pipeline;
}

std::map<Stage, StageState> states(const s3::Pipeline& pipeline) {
  std::map<Stage, StageState> states;
  for (const auto& record : pipeline.stages()) states[record.stage] = record.state;
  return states;
}

}  // namespace

TEST_CASE("a volume mesh goes all the way to a program") {
  auto pipeline = ready_pipeline();
  s3::Context ctx(2);
  int steps = 0;
  while (pipeline.advance(ctx)) ++steps;
  CHECK(steps == static_cast<int>(pipeline.stages().size()));
  CHECK_FALSE(pipeline.advance(ctx));
  for (const auto& record : pipeline.stages()) CHECK(record.state == StageState::done);
  const auto& a = pipeline.artifacts();
  CHECK(a.rest.tet_count() == 4 * 3 * 5 * 6);
  CHECK(a.curved.layers.layers.size() > 5);
  CHECK(a.curved.waypoints.size() > 100);
  CHECK(*a.curved_metrics.support_free_area_percent > *a.planar_metrics.support_free_area_percent);
  CHECK(*a.curved_metrics.foldovers == 0);
  CHECK(*a.planar_metrics.foldovers == 0);
  CHECK(*a.planar_metrics.support_volume_mm3 > 0);
  std::vector<std::string> names;
  for (const auto& record : pipeline.stages())
    s3::write_stage_files(pipeline, record.stage,
                          [&](const std::string& name, const std::string& content) {
                            names.push_back(name);
                            CHECK_MESSAGE(!content.empty(), name);
                          });
  for (const char* name :
       {"fields.vtu", "layers/0000.ply", "waypoints.csv", "support_free.svg", "thickness.svg"})
    CHECK_MESSAGE(std::find(names.begin(), names.end(), name) != names.end(), name);
}

TEST_CASE("a changed parameter makes its own stage and the later ones stale") {
  auto pipeline = ready_pipeline();
  s3::Context ctx;
  pipeline.run_to(Stage::waypoints, ctx);
  s3::Params params;
  params.toolpath.spacing = 2;
  pipeline.set_params(params, machine());
  auto now = states(pipeline);
  CHECK(now[Stage::toolpaths] == StageState::done);
  CHECK(now[Stage::waypoints] == StageState::stale);
  CHECK(now[Stage::metrics] == StageState::fresh);
  // Both thicknesses grow with the nozzle: their ratio, and with it the field, stays.
  params.layers.nozzle_diameter = 1.2;
  pipeline.set_params(params, machine());
  now = states(pipeline);
  CHECK(now[Stage::outer_loop] == StageState::done);
  CHECK(now[Stage::layers] == StageState::stale);
  params.layers.max_thickness = 1.1;
  pipeline.set_params(params, machine());
  now = states(pipeline);
  CHECK(now[Stage::objectives] == StageState::done);
  CHECK(now[Stage::outer_loop] == StageState::stale);
  params.input.scale = 2;
  pipeline.set_params(params, machine());
  CHECK(states(pipeline)[Stage::mesh] == StageState::stale);
}

TEST_CASE("setting the same parameters again changes nothing") {
  auto pipeline = ready_pipeline();
  s3::Context ctx;
  pipeline.run_to(Stage::toolpaths, ctx);
  pipeline.set_params(s3::Params{}, machine());
  CHECK(pipeline.is_done(Stage::toolpaths));
}

TEST_CASE("only stale stages run again, and end where a fresh run ends") {
  auto pipeline = ready_pipeline();
  s3::Context ctx;
  pipeline.run_to(Stage::layers, ctx);
  s3::Params params;
  params.layers.nozzle_diameter = 1.5;
  pipeline.set_params(params, machine());
  std::vector<Stage> ran;
  ctx.on_progress = [&](Stage stage, double fraction) {
    if (fraction == 0 && (ran.empty() || ran.back() != stage)) ran.push_back(stage);
  };
  pipeline.run_to(Stage::layers, ctx);
  CHECK(ran == std::vector<Stage>{Stage::layers});
  s3::Pipeline fresh;
  fresh.set_params(params, machine());
  fresh.set_model(bytes_of(leaning_block()), "block.tet");
  fresh.run_to(Stage::layers, ctx);
  const auto& a = pipeline.artifacts().curved.layers;
  const auto& b = fresh.artifacts().curved.layers;
  REQUIRE(a.layers.size() == b.layers.size());
  for (std::size_t i = 0; i < a.layers.size(); ++i) {
    CHECK(a.layers[i].surface.vertices == b.layers[i].surface.vertices);
    CHECK(a.layers[i].thickness == b.layers[i].thickness);
  }
}

TEST_CASE("a cancel in any stage stops there, keeps what is done, and the run can go on") {
  auto pipeline = ready_pipeline();
  for (std::size_t i = 0; i < pipeline.stages().size(); ++i) {
    const Stage stage = pipeline.stages()[i].stage;
    s3::Context ctx;
    ctx.on_progress = [&](Stage at, double) {
      if (at == stage) ctx.cancel_requested = true;
    };
    CHECK_THROWS_AS(pipeline.run_to(stage, ctx), s3::Cancelled);
    CHECK(pipeline.stages()[i].state == StageState::fresh);
    for (std::size_t earlier = 0; earlier < i; ++earlier)
      CHECK(pipeline.stages()[earlier].state == StageState::done);
    s3::Context again;
    CHECK_NOTHROW(pipeline.run_to(stage, again));
    CHECK(pipeline.is_done(stage));
  }
}

TEST_CASE("wrong input fails in its own stage with an input error") {
  s3::Context ctx;
  auto pipeline = ready_pipeline();
  pipeline.set_model(bytes_of("no mesh at all"), "noise.stl");
  try {
    pipeline.run_to(Stage::metrics, ctx);
    FAIL("no error was thrown");
  } catch (const s3::Error& error) {
    CHECK(error.kind == s3::ErrorKind::input);
    CHECK(error.stage == Stage::mesh);
  }
  CHECK(states(pipeline)[Stage::mesh] == StageState::failed);
  pipeline.set_model(bytes_of(leaning_block()), "block.tet");
  s3::Params strong;
  strong.objectives.strength = 0.5;
  pipeline.set_params(strong, machine());
  CHECK_THROWS_AS(pipeline.run_to(Stage::metrics, ctx), s3::Error);
  CHECK(states(pipeline)[Stage::fea] == StageState::failed);
  CHECK(states(pipeline)[Stage::tetrahedralize] == StageState::done);
}

TEST_CASE("imported stress follows the file's order of tets and turns with the mesh") {
  const auto mesh = s3::test::make_grid(3, 2, 2, {6, 4, 4});
  std::string csv;
  for (s3::Index t = 0; t < mesh.tet_count(); ++t)  // tension along the file's y, by row
    csv += std::to_string(t + 1) + ",0,1,0,1\n";
  s3::Params params;
  params.input.up = std::string("y");
  params.objectives.strength = 0.5;
  s3::Pipeline pipeline;
  pipeline.set_params(params, machine());
  pipeline.set_model(bytes_of(s3::write_tet(mesh.vertices, mesh.tets)), "box.tet");
  pipeline.set_stress(bytes_of(csv), "stress.csv");
  s3::Context ctx;
  pipeline.run_to(Stage::objectives, ctx);
  const auto& a = pipeline.artifacts();
  REQUIRE(a.stress.has_value());
  CHECK(a.stress->critical_tets.size() == static_cast<std::size_t>(0.3 * mesh.tet_count()));
  for (s3::Index row = 0; row < mesh.tet_count(); ++row) {
    const s3::Index t = a.file_order.tets[static_cast<std::size_t>(row)];
    CHECK(a.stress->principal_value(t) == row + 1);
    CHECK(std::abs(a.stress->principal(t, 2)) == doctest::Approx(1));  // y became z
    const s3::Vec3 placed = a.placement * mesh.centroid(row);
    CHECK((placed - a.rest.centroid(t)).norm() < 1e-9);
  }
}
