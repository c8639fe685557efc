#include "pipeline/pipeline.h"

#include <algorithm>
#include <map>
#include <span>

#include <doctest/doctest.h>

#include "base/error.h"
#include "grid_mesh.h"
#include "mesh/write_mesh.h"
#include "pipeline/face_angles.h"
#include "pipeline/outputs.h"
#include "quaternion_field/concavity_weights.h"

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
    for (const auto& file : s3::stage_files(pipeline, record.stage)) {
      names.push_back(file.name);
      CHECK(file.stage == record.stage);
      CHECK_MESSAGE(!file.content().empty(), file.name);
    }
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

namespace {

/// A block of 6×4×4 mm in a file with y up, held below and pulled at one side.
s3::Pipeline pulled_block(const std::string& load, const s3::Params& params) {
  const auto mesh = s3::test::make_grid(6, 4, 4, {6, 4, 4});
  s3::Pipeline pipeline;
  pipeline.set_params(params, machine());
  pipeline.set_model(bytes_of(s3::write_tet(mesh.vertices, mesh.tets)), "block.tet");
  pipeline.set_load_case(bytes_of(load), "block.load.json");
  return pipeline;
}

// In the placed frame the file's y is z, and its z is −y.
const std::string kPulledUp = R"({"conditions": [{"region": "plate", "fixed": true},
  {"region": {"plane": {"point": [0, 0, 4], "normal": [0, 0, 1]}}, "force": [0, 0, 40]}]})";

}  // namespace

TEST_CASE("a load case gives stress in the placed frame, which a file of it gives back") {
  s3::Params params;
  params.input.up = std::string("y");
  params.objectives.strength = 0.5;
  s3::Context ctx;
  auto pipeline = pulled_block(kPulledUp, params);
  pipeline.run_to(Stage::fea, ctx);
  const s3::StressField computed = *pipeline.artifacts().stress;
  const s3::Values volume = s3::tet_volumes(pipeline.artifacts().rest);
  // 40 N over 6×4 mm on average, along z.
  CHECK(volume.dot(computed.stress.col(2)) / volume.sum() ==
        doctest::Approx(40.0 / 24).epsilon(1e-6));
  CHECK(computed.critical_tets.size() == static_cast<std::size_t>(0.3 * 576));

  const auto files = s3::stage_files(pipeline, Stage::fea);
  REQUIRE(files.size() == 1);
  CHECK(files[0].name == "stress.csv");
  const std::string csv = files[0].content();
  pipeline.set_load_case({}, "");
  pipeline.set_stress(bytes_of(csv), "stress.csv");
  pipeline.run_to(Stage::fea, ctx);
  const s3::StressField& imported = *pipeline.artifacts().stress;
  CHECK((imported.stress - computed.stress).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((imported.principal_value - computed.principal_value).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(imported.critical_tets == computed.critical_tets);
}

TEST_CASE("the analysis runs again for its own input only") {
  s3::Params params;
  s3::Context ctx;
  auto pipeline = pulled_block(kPulledUp, params);
  pipeline.run_to(Stage::fea, ctx);
  pipeline.set_load_case(bytes_of(kPulledUp), "block.load.json");  // the same again
  CHECK(states(pipeline)[Stage::fea] == StageState::done);
  params.objectives.alpha_deg = 40;
  params.layers.nozzle_diameter = 0.8;
  pipeline.set_params(params, machine());
  CHECK(states(pipeline)[Stage::fea] == StageState::done);
  params.strength.critical_ratio = 0.1;
  params.strength.smoothing = 1;
  pipeline.set_params(params, machine());
  CHECK(states(pipeline)[Stage::fea] == StageState::stale);
  const double before = pipeline.artifacts().stress->principal_value.maxCoeff();
  pipeline.run_to(Stage::fea, ctx);
  CHECK(pipeline.artifacts().stress->critical_tets.size() == 57);
  CHECK(pipeline.artifacts().stress->principal_value.maxCoeff() < before);
  pipeline.set_load_case(bytes_of("{}"), "empty.json");
  CHECK(states(pipeline)[Stage::fea] == StageState::stale);
  CHECK_THROWS_AS(pipeline.run_to(Stage::fea, ctx), s3::Error);
  pipeline.set_load_case(bytes_of(kPulledUp), "block.load.json");
  pipeline.set_stress(bytes_of("1 1 0 0 1\n"), "stress.csv");
  CHECK_THROWS_AS(pipeline.run_to(Stage::fea, ctx), s3::Error);  // two sources
}

TEST_CASE("region files bound SQ to some faces and add tets to S, each from its own stage on") {
  s3::Params params;
  params.input.up = std::string("y");
  params.objectives.strength = 0.5;
  params.objectives.surface_quality = 0.5;
  params.strength.critical_ratio = 0;
  s3::Context ctx;
  auto pipeline = pulled_block(kPulledUp, params);
  pipeline.run_to(Stage::objectives, ctx);
  const s3::Artifacts& a = pipeline.artifacts();
  CHECK(a.stress->critical_tets.empty());

  const std::string lower =
      R"({"region": {"half_space": {"point": [0, 0, 2], "normal": [0, 0, -1]}}})";
  pipeline.set_surface_region(bytes_of(lower), "lower.json");
  CHECK(states(pipeline)[Stage::fea] == StageState::done);
  CHECK(states(pipeline)[Stage::objectives] == StageState::stale);
  pipeline.set_critical_region(bytes_of(lower), "lower.json");
  CHECK(states(pipeline)[Stage::tetrahedralize] == StageState::done);
  CHECK(states(pipeline)[Stage::fea] == StageState::stale);
  pipeline.run_to(Stage::objectives, ctx);
  CHECK(a.stress->critical_tets.size() == 576 / 2);
  for (s3::Index t = 0; t < a.rest.tet_count(); ++t)
    CHECK((a.objectives.critical[t] != 0) == (a.rest.centroid(t).z() < 2));
  for (std::size_t f = 0; f < a.objectives.face_wants_quality.size(); ++f) {
    const auto& corners = a.rest.boundary_faces.row(static_cast<Eigen::Index>(f));
    double z = 0;
    for (int i = 0; i < 3; ++i) z += a.rest.vertices(corners[i], 2) / 3;
    CHECK((a.objectives.face_wants_quality[f] != 0) == (z < 2 && !a.objectives.face_exempt[f]));
  }
  pipeline.set_surface_region({}, "");
  params.objectives.surface_region = "gone.json";
  pipeline.set_params(params, machine());
  try {
    pipeline.run_to(Stage::objectives, ctx);
    FAIL("a file that was not given");
  } catch (const s3::Error& error) {
    CHECK(error.code == "objectives.no_region");
    CHECK(std::string(error.what()).find("gone.json") != std::string::npos);
  }
}

TEST_CASE("with a load case the report compares the strain of curved and planar beads") {
  s3::Params params;
  params.objectives.strength = 1;
  s3::Context ctx;
  // Pulled along x; beads follow the block's outline, so they lie along the pull and across it.
  auto pipeline = pulled_block(R"({"conditions": [
      {"region": "plate", "fixed": "z"},
      {"region": {"plane": {"point": [0, 0, 0], "normal": [-1, 0, 0]}}, "fixed": "xy"},
      {"region": {"plane": {"point": [6, 0, 0], "normal": [1, 0, 0]}}, "force": [30, 0, 0]}]})",
                               params);
  pipeline.run_to(Stage::metrics, ctx);
  for (const auto* metrics :
       {&pipeline.artifacts().curved_metrics, &pipeline.artifacts().planar_metrics}) {
    REQUIRE(metrics->strain.has_value());
    const double stress = 30.0 / 16;  // MPa
    CHECK(metrics->strain->mean > stress / 3500);
    CHECK(metrics->strain->mean < stress / 1200);
    CHECK(metrics->strain->p999 >= metrics->strain->mean);
    CHECK(metrics->strain->max >= metrics->strain->p999);
  }
}

TEST_CASE("flags on faces and gouging places say what the metrics count") {
  auto pipeline = ready_pipeline();
  s3::Context ctx;
  pipeline.run_to(Stage::metrics, ctx);
  const auto& a = pipeline.artifacts();
  const auto share = [&](const std::vector<char>& flags) {
    double flagged = 0, total = 0;
    for (std::size_t f = 0; f < flags.size(); ++f) {
      if (a.objectives.face_exempt[f]) {
        CHECK(flags[f] == 0);
        continue;
      }
      const double area = a.objectives.face_area(static_cast<Eigen::Index>(f));
      total += area;
      if (flags[f]) flagged += area;
    }
    return 100 * flagged / total;
  };
  const auto curved = s3::face_angles(a, pipeline.params(), a.deformation.field.print_direction);
  const auto planar =
      s3::face_angles(a, pipeline.params(), s3::upright_directions(a.rest.tet_count()));
  CHECK(share(curved.overhang) ==
        doctest::Approx(100 - *a.curved_metrics.support_free_area_percent));
  CHECK(share(planar.overhang) ==
        doctest::Approx(100 - *a.planar_metrics.support_free_area_percent));
  CHECK(share(planar.overhang) > 1);
  CHECK(share(curved.stairs) ==
        doctest::Approx(100 - *a.curved_metrics.surface_quality_area_percent));

  s3::MachineProfile narrow = machine();
  narrow.head_cone_angle = 3.1;  // rad: almost flat, so that any valley counts
  const auto places = s3::gouging_places(a, narrow);
  REQUIRE(places.pairs.rows() > 0);
  CHECK(places.pairs.rows() ==
        s3::gouging_pairs(s3::concave_angles(a.rest, a.deformation.field.print_direction),
                          narrow.head_cone_angle));
  for (Eigen::Index i = 0; i < places.pairs.rows(); ++i) {
    CHECK(places.concave_deg[i] > places.clearance_deg);
    const s3::Vec3 between =
        0.5 * (a.rest.centroid(places.pairs(i, 0)) + a.rest.centroid(places.pairs(i, 1)));
    CHECK((s3::Vec3(places.places.row(i)) - between).norm() < s3::mean_edge_length(a.rest));
  }
}

TEST_CASE("the same file again makes nothing stale, another name does") {
  auto pipeline = ready_pipeline();
  s3::Context ctx;
  pipeline.run_to(Stage::objectives, ctx);
  pipeline.set_model(bytes_of(leaning_block()), "block.tet");
  pipeline.set_stress({}, "");
  CHECK(states(pipeline)[Stage::objectives] == StageState::done);
  pipeline.set_model(bytes_of(leaning_block()), "other.tet");
  CHECK(states(pipeline)[Stage::mesh] == StageState::stale);
  CHECK(s3::stage_files(pipeline, Stage::mesh).empty());
}

namespace {

/// The leaning block as a surface, held at its foot and pulled at its head: something for every
/// stage to do.
s3::Pipeline busy_pipeline() {
  const auto mesh = s3::test::make_grid(4, 3, 5, {8, 6, 10}, [](const s3::Vec3& p) -> s3::Vec3 {
    return {p.x() + 1.2 * std::max(0.0, p.z() - 2), p.y(), p.z()};
  });
  s3::Params params;
  params.mesh.target_tets = 1500;
  params.layers.nozzle_diameter = 2;  // few layers
  params.objectives.strength = 0.3;
  params.objectives.surface_quality = 0.3;
  params.strength.load_case = "block.load.json";
  s3::Pipeline pipeline;
  pipeline.set_params(params, machine());
  pipeline.set_model(bytes_of(s3::write_stl(s3::boundary_surface(mesh))), "block.stl");
  pipeline.set_load_case(bytes_of(R"({"conditions": [
      {"region": "plate", "fixed": true},
      {"region": {"plane": {"point": [0, 0, 10], "normal": [0, 0, 1]}}, "force": [0, 0, 20]}]})"),
                         "block.load.json");
  return pipeline;
}

}  // namespace

TEST_CASE("after cancels at many moments of every stage the results are those without a cancel") {
  auto calm = busy_pipeline();
  std::vector<long> checkpoints;
  {
    s3::Context ctx;
    long count = 0;
    ctx.on_checkpoint = [&] { ++count; };
    while (calm.advance(ctx)) {
      checkpoints.push_back(count);
      count = 0;
    }
  }
  auto disturbed = busy_pipeline();
  for (std::size_t i = 0; i < checkpoints.size(); ++i) {
    constexpr long kMoments = 4;
    for (long moment = 0; moment <= kMoments; ++moment) {
      const long at = 1 + moment * (checkpoints[i] - 1) / kMoments;  // the first … the last
      s3::Context ctx;
      long count = 0;
      ctx.on_checkpoint = [&] { ctx.cancel_requested = ++count == at; };
      CHECK_THROWS_AS(disturbed.advance(ctx), s3::Cancelled);
      CHECK(disturbed.stages()[i].state == StageState::fresh);
    }
    s3::Context ctx;
    disturbed.advance(ctx);
    REQUIRE(disturbed.stages()[i].state == StageState::done);
    CHECK(disturbed.stages()[i].warnings.size() == calm.stages()[i].warnings.size());
  }
  const s3::Artifacts &a = calm.artifacts(), &b = disturbed.artifacts();
  CHECK(a.rest.vertices == b.rest.vertices);
  CHECK(a.rest.tets == b.rest.tets);
  CHECK(a.stress->stress == b.stress->stress);
  CHECK(a.deformation.field.value == b.deformation.field.value);
  CHECK(a.curved.waypoints.position == b.curved.waypoints.position);
  CHECK(a.planar.waypoints.position == b.planar.waypoints.position);
  REQUIRE(a.programs.size() == b.programs.size());
  REQUIRE(!a.programs.empty());
  for (std::size_t i = 0; i < a.programs.size(); ++i)
    CHECK(a.programs[i].content == b.programs[i].content);
  CHECK(*a.curved_metrics.pi_rad == *b.curved_metrics.pi_rad);
  CHECK(a.curved_metrics.strain->max == b.curved_metrics.strain->max);
}
