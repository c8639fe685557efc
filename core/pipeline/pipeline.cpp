// The steps of the paper's overview (Sec. 2.3), from the model to the machine (Sec. 5.1) and the
// evaluation (Sec. 5.2).
#include "pipeline/pipeline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <utility>

#include "base/units.h"
#include "export/authors_waypoints.h"
#include "export/gcode.h"
#include "fea/loading.h"
#include "fea/read_stress.h"
#include "mesh/parts.h"
#include "mesh/read_mesh.h"
#include "mesh/wall_thickness.h"
#include "motion/five_axis.h"
#include "params/param_visitors.h"
#include "pipeline/evaluate.h"
#include "pipeline/prepare_mesh.h"
#include "toolpaths/make_toolpaths.h"
#include "waypoints/make_waypoints.h"

namespace s3 {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// CPU seconds of all threads so far, where the C library counts them.
std::optional<double> cpu_seconds() {
#ifdef __EMSCRIPTEN_PTHREADS__
  return std::nullopt;
#else
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
#endif
}

/// d_max/d_min, rounded: thicknesses that grow together must not change it in the last digit, or
/// the field would be made again.
double thickness_ratio(const Params& params) {
  constexpr double kDigits = 1e9;
  return std::round(kDigits * params.layers.max_thickness / params.layers.min_thickness) / kDigits;
}

/// Row file_row[i] of the result is row i of the file; an empty order keeps the rows.
StressField in_mesh_order(const StressField& file, const std::vector<Index>& file_row) {
  if (file_row.empty()) return file;
  StressField stress = file;
  for (Eigen::Index i = 0; i < file.principal_value.size(); ++i) {
    const Index t = file_row[static_cast<std::size_t>(i)];
    if (file.stress.rows() > 0) stress.stress.row(t) = file.stress.row(i);
    stress.principal.row(t) = file.principal.row(i);
    stress.principal_value(t) = file.principal_value(i);
  }
  for (Index& t : stress.critical_tets) t = file_row[static_cast<std::size_t>(t)];
  std::sort(stress.critical_tets.begin(), stress.critical_tets.end());
  return stress;
}

/// A parameter names a file; its content is given beside it.
void expect_file(const InputFile& file, Stage stage, const std::string& key,
                 const std::string& name) {
  if (name.empty() || !file.bytes.empty()) return;
  throw Error(ErrorKind::input, stage, std::string(stage_name(stage)) + ".no_region",
              key + " names " + name + ", which was not given or is empty",
              "give the file's content, or name none");
}

/// The baseline's layers, as in the paper's comparison: 0.8 mm under a nozzle of 1 mm (Sec. 5.3).
constexpr double kPlanarHeight = 0.8;  // of the largest thickness

}  // namespace

std::string_view stage_label(Stage stage) {
  switch (stage) {
    case Stage::mesh:
      return "Model";
    case Stage::tetrahedralize:
      return "Tetrahedra";
    case Stage::fea:
      return "Stress";
    case Stage::objectives:
      return "Objectives";
    case Stage::outer_loop:
      return "Print directions";
    case Stage::layers:
      return "Layers";
    case Stage::toolpaths:
      return "Toolpaths";
    case Stage::waypoints:
      return "Waypoints";
    case Stage::motion:
      return "Motion";
    case Stage::exporting:
      return "Programs";
    case Stage::metrics:
      return "Evaluation";
    default:
      return stage_name(stage);  // a step inside of another stage
  }
}

const std::vector<Pipeline::Step>& Pipeline::steps() {
  static const std::vector<Step> kSteps = {
      {Stage::mesh, &Pipeline::read_model},        {Stage::tetrahedralize, &Pipeline::make_tets},
      {Stage::fea, &Pipeline::find_stress},        {Stage::objectives, &Pipeline::set_objectives},
      {Stage::outer_loop, &Pipeline::deform_part}, {Stage::layers, &Pipeline::slice},
      {Stage::toolpaths, &Pipeline::make_paths},   {Stage::waypoints, &Pipeline::place_waypoints},
      {Stage::motion, &Pipeline::plan_moves},      {Stage::exporting, &Pipeline::write_programs},
      {Stage::metrics, &Pipeline::evaluate},
  };
  return kSteps;
}

void Pipeline::read_model(Context& ctx) {
  if (model_.bytes.empty())
    throw Error(ErrorKind::input, Stage::mesh, "mesh.empty_file",
                model_.name.empty() ? "No model was given" : model_.name + " is empty",
                std::string("give a surface as ") + kSurfaceFormats + ", or a volume mesh as " +
                    kVolumeFormats);
  ModelFile file = s3::read_model(model_.bytes, model_.name);
  ctx.checkpoint();
  for (Warning& warning : file.warnings) ctx.warnings.push_back(std::move(warning));
  artifacts_.model = {};
  artifacts_.model.format = file.format;
  artifacts_.model.is_volume = file.is_volume;
  if (file.is_volume) {
    prepare_volume(std::move(file), params_.input, artifacts_, ctx);
  } else {
    prepare_surface(std::move(file), params_.input, artifacts_, ctx);
  }
}

void Pipeline::make_tets(Context& ctx) {
  if (!artifacts_.model.is_volume) {  // a volume is used as it is
    TetrahedralizeParams params = params_.mesh;
    const TriMesh& given = artifacts_.given;
    if (params.target_tets == 0)
      params.target_tets = automatic_target(given, measure_walls(given, ctx));
    fill_surface(params, artifacts_, ctx);
    warn_about_thin_walls(artifacts_.rest, measure_walls(artifacts_.surface, ctx),
                          params.target_tets, ctx);
  }
  warn_about_floating_parts(boundary_surface(artifacts_.rest), ctx);
}

/// Smoothing and the critical ratio change without a new solution.
void Pipeline::find_stress(Context& ctx) {
  Artifacts& a = artifacts_;
  a.stress.reset();
  a.load_cases.reset();
  if (!params_.strength.load_case.empty() && load_case_file_.bytes.empty())
    throw Error(ErrorKind::input, Stage::fea, "fea.no_load_case",
                "strength.load_case names " + params_.strength.load_case +
                    ", which was not given or is empty",
                "give the file's content, see models/*.load.json for examples");
  if (!load_case_file_.bytes.empty() && !stress_file_.bytes.empty())
    throw Error(ErrorKind::input, Stage::fea, "fea.two_sources",
                "strength.load_case and strength.stress_file are both set",
                "compute the stress from the load case or import it, not both");
  if (!load_case_file_.bytes.empty()) {
    a.load_cases = read_load_cases(load_case_file_.bytes, load_case_file_.name);
    if (!analysed_) analysed_ = analyse_stress(a.rest, *a.load_cases, ctx);
    a.stress = analysed_;
  } else if (!stress_file_.bytes.empty()) {
    a.stress = imported_stress();
  } else if (params_.objectives.strength > 0) {
    throw Error(ErrorKind::input, Stage::fea, "fea.no_stress",
                "objectives.strength is above 0, but there is no stress field",
                "name a file with strength.load_case or strength.stress_file, or set "
                "objectives.strength to 0");
  } else {
    return;
  }
  smooth_stress(a.rest, params_.strength.smoothing, *a.stress, ctx);
  a.stress->critical_tets =
      critical_tets(a.stress->principal_value, params_.strength.critical_ratio);
  expect_file(critical_region_file_, Stage::fea, "strength.critical_region",
              params_.strength.critical_region);
  if (!critical_region_file_.bytes.empty())
    add_critical_tets(region_tets(a.rest, read_region_file(critical_region_file_.bytes,
                                                           critical_region_file_.name, Stage::fea)),
                      *a.stress);
}

StressField Pipeline::imported_stress() const {
  const StressField in_file_order =
      read_stress(stress_file_.bytes, stress_file_.name, artifacts_.rest.tet_count(),
                  params_.strength.critical_ratio);
  StressField stress = in_mesh_order(in_file_order, artifacts_.file_order.tets);
  rotate_stress(stress, artifacts_.placement.rotation());
  return stress;
}

void Pipeline::set_objectives(Context&) {
  expect_file(surface_region_file_, Stage::objectives, "objectives.surface_region",
              params_.objectives.surface_region);
  std::optional<Region> region;
  if (!surface_region_file_.bytes.empty())
    region =
        read_region_file(surface_region_file_.bytes, surface_region_file_.name, Stage::objectives);
  artifacts_.objectives = make_objectives(artifacts_.rest, params_.objectives,
                                          artifacts_.stress ? &*artifacts_.stress : nullptr,
                                          region ? &*region : nullptr);
}

void Pipeline::deform_part(Context& ctx) {
  artifacts_.deformation = deform(artifacts_.rest, artifacts_.objectives, params_.objectives,
                                  params_.deform, thickness_ratio(params_), ctx);
}

void Pipeline::slice(Context& ctx) {
  artifacts_.curved.layers =
      make_layers(artifacts_.rest, artifacts_.deformation.field, params_.layers, ctx);
}

void Pipeline::make_paths(Context& ctx) {
  artifacts_.curved.toolpaths = paths_on(artifacts_.curved.layers, PathFigures::measured, ctx);
}

Toolpaths Pipeline::paths_on(const LayerStack& layers, PathFigures figures, Context& ctx) const {
  return make_toolpaths(layers, followed_stress(), params_.toolpath, params_.layers.nozzle_diameter,
                        ctx, figures);
}

const StressField* Pipeline::followed_stress() const {
  return artifacts_.stress && params_.objectives.strength > 0 ? &*artifacts_.stress : nullptr;
}

void Pipeline::place_waypoints(Context& ctx) {
  artifacts_.curved.waypoints =
      make_waypoints(artifacts_.curved.layers, artifacts_.curved.toolpaths, settings(), ctx);
}

WaypointSettings Pipeline::settings() const {
  return waypoint_settings(machine_, params_.toolpath, params_.toolpath.width);
}

void Pipeline::plan_moves(Context& ctx) {
  artifacts_.motion = plan_motion(artifacts_.curved.waypoints, machine_, ctx);
}

void Pipeline::write_programs(Context& ctx) {
  artifacts_.programs.clear();
  for (const std::string& name : machine_.programs) {
    ctx.checkpoint();
    if (name == "program.gcode") {
      artifacts_.programs.push_back(
          {name, write_gcode(artifacts_.curved.waypoints, artifacts_.motion, machine_, ctx)});
    } else if (name == "authors-waypoints") {
      const auto texts = write_authors_waypoints(artifacts_.curved.waypoints, ctx);
      for (std::size_t i = 0; i < texts.size(); ++i)
        artifacts_.programs.push_back({name + "/" + std::to_string(i) + ".txt", texts[i]});
    } else {
      throw Error(ErrorKind::input, Stage::exporting, "machine.unknown_program",
                  "the machine " + machine_.name + " asks for " + name +
                      ", which is not a program that can be written",
                  "its profile may list program.gcode and authors-waypoints");
    }
  }
}

void Pipeline::evaluate(Context& ctx) {
  Artifacts& a = artifacts_;
  const DeformResult& result = a.deformation;
  Evaluation curved = evaluate_field(a, result.field, result.deformed, params_, machine_, ctx);
  evaluate_print(a, a.curved, params_, machine_, curved, ctx);

  const auto start = Clock::now();
  const std::size_t own_warnings = ctx.warnings.size();
  a.planar = print_planar(ctx);
  const ScalarField height = make_scalar_field(a.rest, a.rest.vertices.col(2));
  Evaluation planar = evaluate_field(a, height, a.rest.vertices, params_, machine_, ctx);
  evaluate_print(a, a.planar, params_, machine_, planar, ctx);
  planar_seconds_ = seconds_since(start);
  // What is wrong with the baseline must not pass for a fault of the curved layers.
  for (std::size_t i = own_warnings; i < ctx.warnings.size(); ++i) {
    ctx.warnings[i].code.insert(0, "planar.");
    ctx.warnings[i].message.insert(0, "Planar baseline: ");
  }

  a.curved_metrics = curved.metrics;
  a.planar_metrics = planar.metrics;
  a.plots = histograms(curved.plots, planar.plots, result.residual_history,
                       params_.layers.min_thickness, params_.layers.max_thickness);
}

Print Pipeline::print_planar(Context& ctx, PathFigures figures) const {
  const double height = kPlanarHeight * params_.layers.max_thickness;
  Print print;
  print.layers = make_planar_layers(artifacts_.rest, height, params_.layers, ctx);
  print.toolpaths = paths_on(print.layers, figures, ctx);
  print.waypoints = make_waypoints(print.layers, print.toolpaths, settings(), ctx);
  return print;
}

Waypoints Pipeline::curved_waypoints(Context& ctx) const {
  const LayerStack& layers = artifacts_.curved.layers;
  return make_waypoints(layers, paths_on(layers, PathFigures::left_out, ctx), settings(), ctx);
}

namespace {

// What is wrong with the model's surface is said by stages that do not know its file.
Error naming_model(const Error& error, const std::string& name) {
  const std::string said = error.what();
  const bool about_model = error.kind == ErrorKind::input && error.stage <= Stage::tetrahedralize;
  if (!about_model || name.empty() || said.find(name) != std::string::npos) return error;
  return {error.kind, error.stage, error.code, name + ": " + said, error.hint, error.where};
}

/// @return false if `file` is what is given already
bool replace(InputFile& file, std::span<const std::byte> bytes, std::string name) {
  if (std::equal(bytes.begin(), bytes.end(), file.bytes.begin(), file.bytes.end()) &&
      name == file.name)
    return false;
  file = {std::move(name), {bytes.begin(), bytes.end()}};
  return true;
}

}  // namespace

Pipeline::Pipeline() {
  for (const Step& step : steps()) stages_.push_back({step.stage, StageState::fresh, 0, {}, {}});
}

void Pipeline::set_model(std::span<const std::byte> bytes, std::string file_name) {
  if (replace(model_, bytes, std::move(file_name))) mark_stale(Stage::mesh);
}

void Pipeline::set_stress(std::span<const std::byte> bytes, std::string file_name) {
  if (replace(stress_file_, bytes, std::move(file_name))) mark_stale(Stage::fea);
}

void Pipeline::set_load_case(std::span<const std::byte> bytes, std::string file_name) {
  if (!replace(load_case_file_, bytes, std::move(file_name))) return;
  analysed_.reset();
  mark_stale(Stage::fea);
}

void Pipeline::set_surface_region(std::span<const std::byte> bytes, std::string file_name) {
  if (replace(surface_region_file_, bytes, std::move(file_name))) mark_stale(Stage::objectives);
}

void Pipeline::set_critical_region(std::span<const std::byte> bytes, std::string file_name) {
  if (replace(critical_region_file_, bytes, std::move(file_name))) mark_stale(Stage::fea);
}

void Pipeline::set_params(const Params& params, const MachineProfile& machine) {
  Params resolved = resolve(params, machine);
  const ParamList old_list = list_params(params_), new_list = list_params(resolved);
  // The range of ‖∇G‖ follows from the ratio of the thicknesses, so the field depends on it too.
  if (thickness_ratio(resolved) != thickness_ratio(params_)) mark_stale(Stage::outer_loop);
  for (const std::size_t i : diff(old_list, new_list)) mark_stale(new_list.params()[i].info.stage);
  if (!(machine == machine_)) mark_stale(Stage::waypoints);  // speeds and filament
  params_ = std::move(resolved);
  machine_ = machine;
}

void Pipeline::mark_stale(Stage first) {
  if (first < Stage::fea) analysed_.reset();  // another mesh
  for (StageRecord& record : stages_)
    if (record.stage >= first && record.state != StageState::fresh)
      record.state = StageState::stale;
}

bool Pipeline::is_done(Stage stage) const {
  return std::any_of(stages_.begin(), stages_.end(), [&](const StageRecord& record) {
    return record.stage == stage && record.state == StageState::done;
  });
}

bool Pipeline::advance(Context& ctx) {
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (stages_[i].state == StageState::done) continue;
    run_step(i, ctx);
    return true;
  }
  return false;
}

void Pipeline::run_to(Stage last, Context& ctx) {
  for (std::size_t i = 0; i < stages_.size() && stages_[i].stage <= last; ++i)
    if (stages_[i].state != StageState::done) run_step(i, ctx);
}

void Pipeline::run_step(std::size_t position, Context& ctx) {
  StageRecord& record = stages_[position];
  const StageState before = record.state;
  record.state = StageState::running;
  ctx.warnings.clear();
  const auto start = Clock::now();
  const std::optional<double> cpu_start = cpu_seconds();
  try {
    ctx.progress(record.stage, 0);
    (this->*steps()[position].run)(ctx);
    ctx.progress(record.stage, 1);
  } catch (const Cancelled&) {
    record.state = before == StageState::done ? StageState::stale : before;
    throw;
  } catch (const Error& error) {
    record.state = StageState::failed;
    throw naming_model(error, model_.name);
  } catch (...) {
    record.state = StageState::failed;
    throw;
  }
  record.seconds = seconds_since(start);
  if (cpu_start) record.cpu_seconds = *cpu_seconds() - *cpu_start;
  record.warnings = std::move(ctx.warnings);
  ctx.warnings.clear();
  record.state = StageState::done;
}

}  // namespace s3
