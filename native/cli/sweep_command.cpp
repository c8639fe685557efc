// One model under many triples of weights (Sec. 5.4.3, Fig. 19).
#include <algorithm>
#include <ctime>
#include <new>
#include <utility>

#include "commands.h"
#include "files.h"
#include "mesh/tet_mesh.h"
#include "metrics/strain.h"
#include "params/param_visitors.h"
#include "pipeline/evaluate.h"
#include "progress_line.h"
#include "sweep_table.h"
#include "weight_triples.h"

namespace s3::cli {
namespace {

/// Seconds of all threads since it was made.
class CpuClock {
 public:
  double seconds() const { return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  std::clock_t start_ = std::clock();
};

std::vector<WeightTriple> triples_of(const SweepOptions& options) {
  return options.weights.empty() ? triangular_grid(options.grid) : parse_triples(options.weights);
}

/// Known before any stage has run.
void check_options(const RunOptions& run) {
  if (run.output.empty())
    throw Error(ErrorKind::input, Stage::exporting, "params.no_output",
                "there is no folder to write to", "name one: s3slice sweep MODEL -o OUTDIR");
  for (const auto& [key, text] : run.flags)
    if (key == "objectives.support_free" || key == "objectives.strength" ||
        key == "objectives.surface_quality")
      throw Error(ErrorKind::input, Stage::objectives, "params.swept",
                  "--" + key + " is what a sweep runs through",
                  "give triples with --weights, or steps with --grid");
}

class Sweep {
 public:
  Sweep(const SweepOptions& options, Context& ctx)
      : with_strain_(options.strain),
        params_(collect_params(options.run)),
        triples_(triples_of(options)),
        ctx_(ctx) {
    // The baseline follows the stress if any triple does.
    const auto strongest =
        std::max_element(triples_.begin(), triples_.end(),
                         [](const auto& a, const auto& b) { return a.strength < b.strength; });
    strongest->set(params_.objectives);
    table_.model_file = params_.model;
    table_.asked = triples_.size();
    set_job(pipeline_, params_);
    if (with_strain_ && params_.strength.load_case.empty())
      throw Error(ErrorKind::input, Stage::fea, "fea.no_load_case",
                  "--strain needs loads, but strength.load_case is not set",
                  "name a load case, see models/*.load.json; an imported stress has no loads");
  }

  void run(const std::string& output, ProgressLine& progress) {
    prepare(progress);
    OutputFolder folder(output);
    folder.remove_results();  // of an earlier run or sweep
    measure_planar();
    for (const WeightTriple& triple : triples_) {
      table_.rows.push_back(row_of(triple));
      // After each, so that a cancel costs what has not ended only.
      folder.write("sweep.csv", sweep_csv(table_));
      folder.write("sweep.json", sweep_json(table_, pipeline_));
      folder.write("sweep.svg", sweep_svg(table_));
      const SweepRow& row = table_.rows.back();
      progress.triple_done(name_of(triple), row.cpu_seconds, row.error);
    }
  }

  const SweepTable& table() const { return table_; }
  bool all_done() const {
    return table_.planar_error.empty() &&
           std::all_of(table_.rows.begin(), table_.rows.end(),
                       [](const SweepRow& row) { return row.error.empty(); });
  }

 private:
  /// What no weight changes: mesh, tets, stress.
  void prepare(ProgressLine& progress) {
    const CpuClock clock;
    for (const StageRecord& record : pipeline_.stages()) {
      if (record.stage > Stage::objectives) break;
      pipeline_.run_to(record.stage, ctx_);
      progress.stage_done(record);
    }
    table_.shared_cpu_seconds = clock.seconds();
  }

  void measure_planar() {
    const CpuClock clock;
    table_.planar_error = reason_of_failure([&] {
      const Artifacts& a = pipeline_.artifacts();
      const ScalarField height = make_scalar_field(a.rest, a.rest.vertices.col(2));
      measure_field(height, a.rest.vertices, table_.planar);
      table_.planar.pi_rad.reset();
      if (with_strain_)
        table_.planar.strain =
            strain_of(pipeline_.print_planar(ctx_, PathFigures::left_out).waypoints);
    });
    table_.planar_cpu_seconds = clock.seconds();
  }

  /// The figures as of a run with these weights. What stops one triple does not stop the others.
  SweepRow row_of(const WeightTriple& triple) {
    const CpuClock clock;
    SweepRow row{triple, {}, {}, 0, {}};
    std::vector<Warning> of_print;
    row.error = reason_of_failure([&] {
      triple.set(params_.objectives);
      pipeline_.set_params(params_, pipeline_.machine());
      pipeline_.run_to(Stage::outer_loop, ctx_);
      const DeformResult& result = pipeline_.artifacts().deformation;
      measure_field(result.field, result.deformed, row.metrics);
      if (!with_strain_) return;
      pipeline_.run_to(Stage::layers, ctx_);
      ctx_.warnings.clear();
      row.metrics.strain = strain_of(pipeline_.curved_waypoints(ctx_));
      of_print = std::move(ctx_.warnings);
    });
    for (const StageRecord& record : pipeline_.stages())
      if (record.stage > Stage::objectives && record.state == StageState::done)
        row.warnings.insert(row.warnings.end(), record.warnings.begin(), record.warnings.end());
    row.warnings.insert(row.warnings.end(), of_print.begin(), of_print.end());
    row.cpu_seconds = clock.seconds();
    return row;
  }

  /// Empty if `work` succeeds.
  /// @throws Cancelled
  template <class Work>
  static std::string reason_of_failure(Work&& work) {
    try {
      work();
    } catch (const Error& error) {
      return error.what() + (error.hint.empty() ? "" : "; " + error.hint);
    } catch (const std::bad_alloc&) {
      return "there is not enough memory";
    }
    return {};
  }

  void measure_field(const ScalarField& field, const Points& deformed, Metrics& metrics) {
    metrics = evaluate_field(pipeline_.artifacts(), field, deformed, pipeline_.params(),
                             pipeline_.machine(), ctx_)
                  .metrics;
  }

  StrainFigures strain_of(const Waypoints& waypoints) {
    const Artifacts& a = pipeline_.artifacts();
    return strain_figures(printed_strain(a.rest, waypoints, *a.load_cases, ctx_),
                          tet_volumes(a.rest));
  }

  bool with_strain_;
  Params params_;
  std::vector<WeightTriple> triples_;
  Context& ctx_;
  Pipeline pipeline_;
  SweepTable table_;
};

}  // namespace

int sweep_command(const SweepOptions& options) {
  InterruptibleContext interruptible(thread_count(options.run.threads));
  Context& ctx = interruptible.context;
  ProgressLine progress(options.run.quiet);
  ctx.on_progress = [&](Stage stage, double fraction) { progress.show(stage, fraction); };
  check_options(options.run);
  Sweep sweep(options, ctx);
  sweep.run(options.run.output, progress);
  if (!options.run.quiet) std::fputs(sweep_text(sweep.table()).c_str(), stdout);
  return sweep.all_done() ? kDone : kSlicingFailed;
}

}  // namespace s3::cli
