// The whole way from a model file to a program, stage by stage. Keeps each result and knows what
// must be done again.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.h"
#include "motion/machine_profile.h"
#include "pipeline/artifacts.h"
#include "pipeline/params.h"
#include "toolpaths/make_toolpaths.h"

namespace s3 {

enum class StageState {
  fresh,  // never done
  running,
  done,
  stale,  // done before, but its input or parameters have changed since
  failed
};

/// The name for people of a stage that the pipeline runs: "Print directions".
std::string_view stage_label(Stage stage);

struct StageRecord {
  Stage stage;
  StageState state = StageState::fresh;
  double seconds = 0;  // wall, of the last run
  /// Of all threads; empty where that cannot be measured (WebAssembly with threads).
  std::optional<double> cpu_seconds;
  std::vector<Warning> warnings;
};

/// A file that was given; without bytes there is none.
struct InputFile {
  std::string name;
  std::vector<std::byte> bytes;
};

class Pipeline {
 public:
  Pipeline();

  /// The model file. Makes everything stale, unless it is the file that was there.
  void set_model(std::span<const std::byte> bytes, std::string file_name);
  /// The file of strength.stress_file; empty bytes for none. Makes the stress and what follows
  /// stale, unless it is the file that was there.
  void set_stress(std::span<const std::byte> bytes, std::string file_name);
  /// The file of strength.load_case; empty bytes for none. Makes the stress and what follows stale,
  /// unless it is the file that was there.
  void set_load_case(std::span<const std::byte> bytes, std::string file_name);
  /// The file of objectives.surface_region; empty bytes for none. Makes the objectives and what
  /// follows stale, unless it is the file that was there.
  void set_surface_region(std::span<const std::byte> bytes, std::string file_name);
  /// The file of strength.critical_region; empty bytes for none. Makes the stress and what follows
  /// stale, unless it is the file that was there.
  void set_critical_region(std::span<const std::byte> bytes, std::string file_name);
  /// Makes stale what the changed parameters' own stages and the machine reach.
  /// @param machine  the profile that params.machine names
  /// @throws Error "params.…" for values that are out of range; nothing is changed then
  void set_params(const Params& params, const MachineProfile& machine);

  /// Runs the first stage that is not done.
  /// @return false if all were done already
  /// @throws Error, Cancelled; earlier stages keep their results
  bool advance(Context& ctx);
  /// Runs every stage up to and including `last` that is not done.
  void run_to(Stage last, Context& ctx);

  const InputFile& model() const { return model_; }
  const InputFile& stress_file() const { return stress_file_; }
  const InputFile& load_case_file() const { return load_case_file_; }
  const InputFile& surface_region_file() const { return surface_region_file_; }
  const InputFile& critical_region_file() const { return critical_region_file_; }

  /// The effective parameters: nothing left to be derived.
  const Params& params() const { return params_; }
  const MachineProfile& machine() const { return machine_; }
  const Artifacts& artifacts() const { return artifacts_; }
  /// The stages in the order in which they run.
  const std::vector<StageRecord>& stages() const { return stages_; }
  bool is_done(Stage stage) const;
  /// Wall seconds that making and measuring the planar baseline took, part of the stage `metrics`.
  double planar_seconds() const { return planar_seconds_; }
  /// The baseline of the comparison: planar layers of the same mesh, printed with the present
  /// parameters. Needs tets, and the stress where the strength objective is on.
  Print print_planar(Context& ctx, PathFigures figures = PathFigures::measured) const;
  /// The waypoints of the stage of that name, for callers who want no figures of the paths on the
  /// way. Needs the layers; keeps nothing.
  Waypoints curved_waypoints(Context& ctx) const;

 private:
  void read_model(Context& ctx);
  void make_tets(Context& ctx);
  void find_stress(Context& ctx);
  StressField imported_stress() const;
  void set_objectives(Context& ctx);
  void deform_part(Context& ctx);
  void slice(Context& ctx);
  void make_paths(Context& ctx);
  void place_waypoints(Context& ctx);
  WaypointSettings settings() const;
  /// What hybrid toolpaths follow; null where the strength objective is off.
  const StressField* followed_stress() const;
  void plan_moves(Context& ctx);
  void write_programs(Context& ctx);
  void evaluate(Context& ctx);
  Toolpaths paths_on(const LayerStack& layers, PathFigures figures, Context& ctx) const;

  struct Step {
    Stage stage;
    void (Pipeline::*run)(Context&);
  };
  static const std::vector<Step>& steps();
  void mark_stale(Stage first);
  void run_step(std::size_t position, Context& ctx);

  InputFile model_, stress_file_, load_case_file_, surface_region_file_, critical_region_file_;
  Params params_;
  MachineProfile machine_;
  Artifacts artifacts_;
  std::optional<StressField> analysed_;  // of the load case, before smoothing, while it holds
  std::vector<StageRecord> stages_;
  double planar_seconds_ = 0;
};

}  // namespace s3
