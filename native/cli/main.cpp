// s3slice: the slicer on the command line.
#include <cstdio>
#include <exception>
#include <list>
#include <new>
#include <string>

#include <CLI/CLI.hpp>

#include "base/error.h"
#include "commands.h"
#include "mesh/read_mesh.h"
#include "params/param_visitors.h"

namespace s3::cli {
namespace {

/// One line, whatever the message was made of.
std::string single_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

void print_error(const std::string& message, const std::string& hint,
                 const std::vector<Vec3>& where, const std::string& code) {
  std::string line = "s3slice: " + message;
  if (!where.empty() && message.find('(') == std::string::npos) {
    char place[96];
    std::snprintf(place, sizeof place, " at (%.4g, %.4g, %.4g)", where[0].x(), where[0].y(),
                  where[0].z());
    line += place;
  }
  if (!hint.empty()) line += "; " + hint;
  if (!code.empty()) line += " [" + code + "]";
  std::fprintf(stderr, "%s\n", single_line(line).c_str());
}

std::string option_help(const ParamInfo& info) {
  std::string text(info.doc);
  if (!info.unit.empty()) text += " (" + std::string(info.unit) + ")";
  return text;
}

/// Every parameter as an option that remembers key and text, in the order given.
void add_parameter_options(CLI::App& command, const ParamList& list, RunOptions& options) {
  for (const ParamRef& param : list.params()) {
    const std::string key(param.info.key);
    command
        .add_option_function<std::string>(
            "--" + key,
            [key, &options](const std::string& text) { options.flags.emplace_back(key, text); },
            option_help(param.info))
        ->type_name("")
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
        ->group("Parameters");
  }
}

/// A typo in a parameter deserves the nearest name, not "unknown argument".
void check_extras(const CLI::App& command, const ParamList& list) {
  for (const std::string& extra : command.remaining()) {
    if (extra.rfind("--", 0) == 0) {
      const std::string key = extra.substr(2, extra.find('=') - 2);
      throw Error(ErrorKind::input, Stage::mesh, "params.unknown_key",
                  "there is no option --" + key,
                  "did you mean --" + std::string(list.nearest_key(key)) +
                      "? `s3slice schema` lists all parameters");
    }
    throw Error(ErrorKind::input, Stage::mesh, "params.extra_argument",
                "\"" + extra + "\" is one argument too many",
                "s3slice " + command.get_name() + " takes one model");
  }
}

/// What every command that slices takes.
void add_job_options(CLI::App& command, const ParamList& list, RunOptions& options) {
  command.allow_extras();
  command.add_option("MODEL", options.model,
                     std::string("A surface as ") + kSurfaceFormats + ", or a volume mesh as " +
                         kVolumeFormats + "; a job file may name it instead");
  command.add_option("-o,--output", options.output, "Folder for the results");
  command
      .add_option("--config", options.configs,
                  "Parameter file (JSON); a later one overrides the one before")
      ->take_all()
      ->expected(1);
  command.add_flag("--quiet", options.quiet, "No progress and no summary");
  command
      .add_option("--threads", options.threads,
                  "Number of threads; the results do not depend on it")
      ->check(CLI::Range(1, 1024));
  add_parameter_options(command, list, options);
}

CLI::App* add_sweep(CLI::App& app, const ParamList& list, SweepOptions& options) {
  CLI::App* sweep = app.add_subcommand(
      "sweep", "Figures of many triples of weights: sweep.csv, sweep.json, sweep.svg");
  CLI::Option* weights =
      sweep
          ->add_option("--weights", options.weights,
                       "Triples SF,SR,SQ, separated by semicolons or options of their own")
          ->take_all()
          ->expected(1);
  sweep
      ->add_option("--grid", options.grid,
                   "Steps along each side of the triangle of weights (4: 15 triples)")
      ->check(CLI::Range(1, 40))
      ->excludes(weights);
  sweep->add_flag("--strain", options.strain,
                  "Also print every triple and analyse its strain: takes ten times as long");
  add_job_options(*sweep, list, options.run);
  return sweep;
}

int parse_and_run(int argc, char** argv) {
  CLI::App app("Curved layers for multi-axis 3D printing", "s3slice");
  app.set_version_flag("--version", S3_VERSION);
  app.require_subcommand(1);

  Params params;
  const ParamList list = list_params(params);
  RunOptions options;
  std::string folder;
  bool as_json = false;

  CLI::App* run =
      app.add_subcommand("run", "Slice a model: layers, toolpaths, waypoints, programs, report");
  add_job_options(*run, list, options);
  run->add_option("--until", options.until, "Stop after this stage");
  SweepOptions sweep_options;
  CLI::App* sweep = add_sweep(app, list, sweep_options);

  CLI::App* inspect = app.add_subcommand(
      "inspect", "Report on a model file: size, holes, self-intersections, shells");
  inspect->add_option("MODEL", options.model, "Model file")->required();
  inspect->add_flag("--json", as_json, "As JSON");

  CLI::App* schema = app.add_subcommand("schema", "Print the JSON Schema of all parameters");
  CLI::App* evaluate =
      app.add_subcommand("evaluate", "Recompute the metrics from the files of a run");
  evaluate->add_option("OUTDIR", folder, "Folder of a run")->required();

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    print_error(error.what(), "see s3slice --help", {}, "params.usage");
    return kInputWrong;
  }
  if (run->parsed()) {
    check_extras(*run, list);
    return run_command(options);
  }
  if (sweep->parsed()) {
    check_extras(*sweep, list);
    return sweep_command(sweep_options);
  }
  if (inspect->parsed()) return inspect_command(options.model, as_json);
  if (schema->parsed()) return schema_command();
  return evaluate_command(folder);
}

int guarded_main(int argc, char** argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const Cancelled&) {
    std::fputs("s3slice: cancelled; the files of finished stages are complete\n", stderr);
    return kCancelledCode;
  } catch (const Error& error) {
    print_error(error.what(), error.hint, error.where, error.code);
    return error.kind == ErrorKind::input ? kInputWrong : kSlicingFailed;
  } catch (const std::bad_alloc&) {
    print_error("there is not enough memory", "use fewer tets (mesh.target_tets)", {},
                "slicing.memory");
    return kSlicingFailed;
  } catch (const std::exception& error) {
    print_error(std::string("an internal error: ") + error.what(),
                "please report it with the job.json", {}, "slicing.internal");
    return kSlicingFailed;
  }
}

}  // namespace
}  // namespace s3::cli

int main(int argc, char** argv) {
  return s3::cli::guarded_main(argc, argv);
}
