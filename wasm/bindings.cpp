// The slicer for JavaScript (embind): the pipeline behind two classes, Engine and Slicer, that
// wasm/index.js wraps. Its types are described in wasm/index.d.ts.
//
// Every method that can fail returns {value} or {error}: no C++ exception crosses into JavaScript.
// Arrays leave as copies: a view of the heap would end with the next growth of the memory.
#include <emscripten.h>
#include <emscripten/bind.h>
#include <emscripten/heap.h>
#include <emscripten/val.h>
#include <malloc.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/units.h"
#include "mesh/read_mesh.h"
#include "metrics/metrics_json.h"
#include "metrics/thickness.h"
#include "motion/machine_profile_json.h"
#include "params/param_visitors.h"
#include "pipeline/face_angles.h"
#include "pipeline/inspect.h"
#include "pipeline/outputs.h"
#include "pipeline/pipeline.h"
#include "pipeline/places_json.h"

namespace s3::wasm {
namespace {

using emscripten::val;
using Json = nlohmann::ordered_json;

// --- values that cross the border
// -----------------------------------------------------------------

val parsed(const Json& json) {
  return val::global("JSON").call<val>("parse",
                                       json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// A copy as a typed array of that name; numbers are converted on the way.
template <class T>
val typed_array(const char* name, const T* data, std::size_t size) {
  return val::global(name).new_(val(emscripten::typed_memory_view(size, data)));
}

/// Reals in the precision that was asked for.
class Reals {
 public:
  explicit Reals(int precision) : name_(precision == 64 ? "Float64Array" : "Float32Array") {}

  template <class Derived>
  val operator()(const Eigen::PlainObjectBase<Derived>& matrix) const {
    return typed_array(name_, matrix.data(), static_cast<std::size_t>(matrix.size()));
  }
  val operator()(const std::vector<double>& values) const {
    return typed_array(name_, values.data(), values.size());
  }

 private:
  const char* name_;
};

template <class Derived>
val indices(const Eigen::PlainObjectBase<Derived>& matrix) {
  return typed_array("Uint32Array", matrix.data(), static_cast<std::size_t>(matrix.size()));
}
val indices(const std::vector<Index>& values) {
  return typed_array("Uint32Array", values.data(), values.size());
}

template <class T>
val bytes(const std::vector<T>& values) {
  static_assert(sizeof(T) == 1);
  return typed_array("Uint8Array", reinterpret_cast<const unsigned char*>(values.data()),
                     values.size());
}
val bytes(const std::string& text) {
  return typed_array("Uint8Array", reinterpret_cast<const unsigned char*>(text.data()),
                     text.size());
}

std::vector<std::byte> bytes_of(const val& array) {
  std::vector<std::byte> bytes(array["length"].as<std::size_t>());
  val(emscripten::typed_memory_view(bytes.size(), reinterpret_cast<unsigned char*>(bytes.data())))
      .call<void>("set", array);
  return bytes;
}

// --- errors
// ---------------------------------------------------------------------------------------

Json error_json(const char* kind, const std::string& code, const Json& stage,
                const std::string& message, const std::string& hint,
                const std::vector<Vec3>& places = {}) {
  return {{"kind", kind},       {"code", code}, {"stage", stage},
          {"message", message}, {"hint", hint}, {"places", places_json(places)}};
}

val failure(const Json& error) {
  val result = val::object();
  result.set("error", parsed(error));
  return result;
}

/// {value: what `function` returns} or {error}.
template <class Function>
val guarded(Function&& function) {
  try {
    val result = val::object();
    if constexpr (std::is_void_v<std::invoke_result_t<Function>>) {
      function();
    } else {
      result.set("value", function());
    }
    return result;
  } catch (const Cancelled&) {
    return failure(error_json("cancelled", "cancelled", nullptr, "The run was cancelled", ""));
  } catch (const Error& error) {
    return failure(error_json(error.kind == ErrorKind::input ? "input" : "slicing", error.code,
                              std::string(stage_name(error.stage)), error.what(), error.hint,
                              error.where));
  } catch (const std::bad_alloc&) {
    return failure(error_json("engine", "engine.crashed", nullptr,
                              "There is not enough memory: a page has at most 4 GB",
                              "Use fewer tets (mesh.target_tets) and load the engine again"));
  } catch (const std::exception& error) {
    return failure(error_json("engine", "engine.crashed", nullptr,
                              std::string("An internal error: ") + error.what(),
                              "Load the engine again, and please report it with the project file"));
  }
}

// --- the engine
// -----------------------------------------------------------------------------------

/// Threads, cancel and progress, shared by the slicers of a module.
class Engine {
 public:
  explicit Engine(int threads) : ctx(threads) {}

  Context ctx;

  /// Address of the byte that other threads may set.
  std::uintptr_t cancel_address() {
    return reinterpret_cast<std::uintptr_t>(&ctx.cancel_requested);
  }
  void set_cancel(bool cancel) { ctx.cancel_requested = cancel; }

  val inspect(const val& array, const std::string& file_name) {
    return guarded([&] { return parsed(inspect_model(bytes_of(array), file_name, ctx)); });
  }
};

static_assert(sizeof(std::atomic<bool>) == 1, "JavaScript sets it as one byte");

std::string schema() {
  Params params;
  return json_schema(list_params(params));
}

val machine_names() {
  return parsed(Json(bundled_machines()));
}

val machine_profile(const std::string& name) {
  return guarded([&] { return parsed(to_json(bundled_machine(name))); });
}

double memory_bytes() {
  return static_cast<double>(emscripten_get_heap_size());
}

double memory_used() {
  return static_cast<double>(mallinfo().uordblks);
}

std::string version() {
  return S3_VERSION;
}

// --- the slicer
// -----------------------------------------------------------------------------------

Json params_json(Params params) {
  return Json::parse(to_json(list_params(params)));
}

Json warnings_json(const std::vector<Warning>& warnings) {
  Json json = Json::array();
  for (const Warning& warning : warnings)
    json.push_back({{"code", warning.code},
                    {"message", warning.message},
                    {"where", places_json(warning.where)}});
  return json;
}

const char* state_name(StageState state) {
  switch (state) {
    case StageState::fresh:
      return "fresh";
    case StageState::running:
      return "running";
    case StageState::done:
      return "done";
    case StageState::stale:
      return "stale";
    case StageState::failed:
      return "failed";
  }
  return "";
}

Json stage_json(const StageRecord& record) {
  return {{"stage", stage_name(record.stage)},
          {"label", stage_label(record.stage)},
          {"state", state_name(record.state)},
          {"seconds", record.seconds},
          {"cpuSeconds", record.cpu_seconds ? Json(*record.cpu_seconds) : Json(nullptr)},
          {"warnings", warnings_json(record.warnings)}};
}

const char* mime_type(const std::string& name) {
  const auto ends_with = [&](const char* end) { return name.ends_with(end); };
  if (ends_with(".json")) return "application/json";
  if (ends_with(".svg")) return "image/svg+xml";
  if (ends_with(".csv")) return "text/csv";
  if (ends_with(".vtu")) return "application/xml";
  if (ends_with(".ply")) return "application/octet-stream";
  return "text/plain";
}

/// Components of a stack as one mesh. Freed as soon as it has been copied out.
struct PackedLayers {
  Points positions, normals;
  Values thickness;
  Triangles triangles;
  std::vector<Index> source_tets, vertex_offsets{0}, index_offsets{0}, isosurfaces, rests_on,
      rests_on_offsets{0};
  std::vector<double> iso_values;
  std::vector<char> partial;
};

PackedLayers pack(const LayerStack& stack) {
  PackedLayers out;
  Eigen::Index vertices = 0, triangles = 0;
  for (const Layer& layer : stack.layers) {
    vertices += layer.surface.vertices.rows();
    triangles += layer.surface.triangles.rows();
  }
  out.positions.resize(vertices, 3);
  out.normals.resize(vertices, 3);
  out.thickness.resize(vertices);
  out.triangles.resize(triangles, 3);
  Eigen::Index v = 0, f = 0;
  for (const Layer& layer : stack.layers) {
    const Eigen::Index nv = layer.surface.vertices.rows(), nf = layer.surface.triangles.rows();
    out.positions.middleRows(v, nv) = layer.surface.vertices;
    out.normals.middleRows(v, nv) = layer.normal;
    out.thickness.segment(v, nv) = layer.thickness;
    out.triangles.middleRows(f, nf) = layer.surface.triangles.array() + static_cast<Index>(v);
    v += nv;
    f += nf;
    out.source_tets.insert(out.source_tets.end(), layer.source_tet.begin(), layer.source_tet.end());
    out.vertex_offsets.push_back(static_cast<Index>(v));
    out.index_offsets.push_back(static_cast<Index>(3 * f));
    out.isosurfaces.push_back(layer.layer);
    out.iso_values.push_back(layer.iso_value);
    out.partial.push_back(layer.partial ? 1 : 0);
    out.rests_on.insert(out.rests_on.end(), layer.rests_on.begin(), layer.rests_on.end());
    out.rests_on_offsets.push_back(static_cast<Index>(out.rests_on.size()));
  }
  return out;
}

val surface_value(const TriMesh& mesh, const Reals& reals) {
  val out = val::object();
  out.set("positions", reals(mesh.vertices));
  out.set("indices", indices(mesh.triangles));
  return out;
}

val weighted(const std::vector<WeightedValue>& pairs, const Reals& reals) {
  std::vector<double> values, weights;
  values.reserve(pairs.size());
  weights.reserve(pairs.size());
  for (const WeightedValue& pair : pairs) {
    values.push_back(pair.value);
    weights.push_back(pair.weight);
  }
  val out = val::object();
  out.set("values", reals(values));
  out.set("weights", reals(weights));
  return out;
}

val file_value(const InputFile& file) {
  if (file.bytes.empty()) return val::null();
  val out = val::object();
  out.set("name", file.name);
  out.set("bytes", bytes(file.bytes));
  return out;
}

/// One pipeline with its files and settings.
class Slicer {
 public:
  explicit Slicer(Engine& engine) : engine_(engine) { apply(given_); }

  // Input.
  val set_model(const val& array, const std::string& name) {
    return guarded([&] {
      pipeline_.set_model(bytes_of(array), name);
      Params params = given_;
      params.model = name;
      apply(params);
    });
  }
  val set_stress(const val& array, const std::string& name) {
    return guarded([&] {
      Params params = given_;
      params.strength.stress_file = name;
      pipeline_.set_stress(bytes_of(array), name);
      apply(params);
    });
  }
  val set_load_case(const val& array, const std::string& name) {
    return guarded([&] {
      const auto file = bytes_of(array);
      if (!file.empty()) read_load_cases(file, name);  // a fault in it is better said now
      Params params = given_;
      params.strength.load_case = name;
      pipeline_.set_load_case(file, name);
      apply(params);
    });
  }
  val set_critical_region(const val& array, const std::string& name) {
    return set_region(
        array, name, Stage::fea, &Pipeline::set_critical_region,
        [](Params& params) -> std::string& { return params.strength.critical_region; });
  }
  val set_surface_region(const val& array, const std::string& name) {
    return set_region(
        array, name, Stage::objectives, &Pipeline::set_surface_region,
        [](Params& params) -> std::string& { return params.objectives.surface_region; });
  }
  val set_params(const std::string& json, bool from_defaults) {
    return guarded([&] {
      Params params = from_defaults ? with_files_of(given_) : given_;
      from_json(list_params(params), json, "the parameters");
      apply(params);
    });
  }
  val set_machine_profile(const std::string& name, const std::string& json) {
    return guarded([&] {
      MachineProfile profile = parse_machine_profile(json, name);
      profiles_.insert_or_assign(name, std::move(profile));
      if (given_.machine.machine == name) apply(given_);
    });
  }

  val given_params() const { return parsed(params_json(given_)); }
  val params() const { return parsed(params_json(pipeline_.params())); }
  val input_files() const {
    val out = val::object();
    out.set("model", file_value(pipeline_.model()));
    out.set("stress", file_value(pipeline_.stress_file()));
    out.set("loadCase", file_value(pipeline_.load_case_file()));
    out.set("criticalRegion", file_value(pipeline_.critical_region_file()));
    out.set("surfaceRegion", file_value(pipeline_.surface_region_file()));
    return out;
  }
  val inspect() {
    return guarded([&] {
      return parsed(inspect_model(pipeline_.model().bytes, pipeline_.model().name, engine_.ctx));
    });
  }
  val file_surface() {
    return guarded([&] {
      ModelFile file = read_model(pipeline_.model().bytes, pipeline_.model().name);
      val out = val::object();
      if (file.is_volume) {
        const TetMesh mesh = make_tet_mesh(std::move(file.vertices), std::move(file.tets));
        out = surface_value(boundary_surface(mesh), Reals(32));
        out.set("partOfTriangle", val::null());
      } else {
        out = surface_value(file.surface, Reals(32));
        out.set("partOfTriangle", indices(file.part_of_triangle));
      }
      out.set("partNames", parsed(Json(file.part_names)));
      return out;
    });
  }

  // Running.
  val stages() const {
    Json json = Json::array();
    for (const StageRecord& record : pipeline_.stages()) json.push_back(stage_json(record));
    return parsed(json);
  }
  /// @param on_progress  (stage name, fraction) => void; must not throw
  val advance(const val& on_progress) {
    return guarded([&] {
      using Clock = std::chrono::steady_clock;
      constexpr auto kInterval = std::chrono::milliseconds(50);
      auto last = Clock::now() - kInterval;
      engine_.ctx.on_progress = [&](Stage stage, double fraction) {
        if (on_progress.isNull() || Clock::now() - last < kInterval) return;
        last = Clock::now();
        on_progress(std::string(stage_name(stage)), fraction);
      };
      const auto next = [&]() -> const StageRecord* {
        for (const StageRecord& record : pipeline_.stages())
          if (record.state != StageState::done) return &record;
        return nullptr;
      };
      const StageRecord* const record = next();
      engine_.ctx.checkpoint();
      if (record != nullptr) pipeline_.advance(engine_.ctx);
      val out = val::object();
      out.set("stage", record ? val(std::string(stage_name(record->stage))) : val::null());
      out.set("state", std::string(next() ? "running" : "done"));
      return out;
    });
  }

  // Results. Each is null while its stage is not done.
  val placement() const {
    if (!pipeline_.is_done(Stage::mesh)) return val::null();
    const Eigen::Matrix4d matrix = artifacts().placement.matrix();  // by columns
    return typed_array("Float64Array", matrix.data(), 16);
  }
  val surface(int precision) const {
    if (!pipeline_.is_done(Stage::mesh)) return val::null();
    const TriMesh& given = artifacts().given;
    return surface_value(given.triangles.rows() > 0 ? given : artifacts().surface,
                         Reals(precision));
  }
  val tets(int precision) const {
    const bool volume = pipeline_.is_done(Stage::mesh) && artifacts().model.is_volume;
    if (!volume && !pipeline_.is_done(Stage::tetrahedralize)) return val::null();
    const TetMesh& rest = artifacts().rest;
    val out = val::object();
    out.set("positions", Reals(precision)(rest.vertices));
    out.set("tets", indices(rest.tets));
    out.set("boundaryFaces", indices(rest.boundary_faces));
    out.set("boundaryTets", indices(rest.boundary_face_tet));
    return out;
  }
  val stress(int precision) const {
    if (!pipeline_.is_done(Stage::fea) || !artifacts().stress) return val::null();
    const StressField& stress = *artifacts().stress;
    const Reals reals(precision);
    std::vector<char> critical(static_cast<std::size_t>(artifacts().rest.tet_count()));
    for (const Index t : stress.critical_tets) critical[static_cast<std::size_t>(t)] = 1;
    val out = val::object();
    out.set("tauMax", reals(stress.principal));
    out.set("sigmaMax", reals(stress.principal_value));
    out.set("critical", bytes(critical));
    out.set("tensors", stress.stress.rows() > 0 ? reals(stress.stress) : val::null());
    return out;
  }
  val faces(int precision) const {
    if (!pipeline_.is_done(Stage::objectives)) return val::null();
    const ObjectiveField& objectives = artifacts().objectives;
    val out = val::object();
    out.set("normals", Reals(precision)(objectives.face_normal));
    out.set("areas", Reals(precision)(objectives.face_area));
    out.set("exempt", bytes(objectives.face_exempt));
    out.set("wantsQuality", bytes(objectives.face_wants_quality));
    return out;
  }
  val deformation(int precision) const {
    if (!pipeline_.is_done(Stage::outer_loop)) return val::null();
    const DeformResult& result = artifacts().deformation;
    const Reals reals(precision);
    const Values lengths = result.field.gradient.rowwise().norm();
    Json islands = Json::array();
    for (const Island& island : result.islands)
      islands.push_back({{"place", {island.place.x(), island.place.y(), island.place.z()}},
                         {"volume", island.volume},
                         {"depth", island.depth}});
    val out = val::object();
    out.set("deformed", reals(result.deformed));
    out.set("field", reals(result.field.value));
    out.set("printDirections", reals(result.field.print_direction));
    out.set("gradientLengths", reals(lengths));
    out.set("rotations", reals(result.rotation));
    out.set("residuals", Reals(64)(result.residual_history));
    out.set("outerIterations", result.outer_iterations);
    out.set("islands", parsed(islands));
    return out;
  }
  val face_angles(bool planar, int precision) const {
    if (!pipeline_.is_done(Stage::outer_loop)) return val::null();
    const FaceAngles angles = s3::face_angles(artifacts(), pipeline_.params(), directions(planar));
    val out = val::object();
    out.set("supportFree", Reals(precision)(angles.support_free));
    out.set("surfaceQuality", Reals(precision)(angles.surface_quality));
    out.set("overhang", bytes(angles.overhang));
    out.set("stairs", bytes(angles.stairs));
    return out;
  }
  val histogram_data(bool planar, int precision) const {
    if (!pipeline_.is_done(Stage::outer_loop)) return val::null();
    const Artifacts& a = artifacts();
    const LpdAngles angles =
        lpd_angles(a.rest, a.objectives, a.stress ? &*a.stress : nullptr, directions(planar));
    const Reals reals(precision);
    val out = val::object();
    out.set("supportFree", weighted(angles.support_free, reals));
    out.set("surfaceQuality", weighted(angles.surface_quality, reals));
    out.set("strength", weighted(angles.strength, reals));
    const bool sliced = pipeline_.is_done(planar ? Stage::metrics : Stage::layers);
    out.set("thickness",
            weighted(sliced ? thickness_values(print(planar).layers) : std::vector<WeightedValue>{},
                     reals));
    return out;
  }
  val gouging(int precision) const {
    if (!pipeline_.is_done(Stage::outer_loop)) return val::null();
    const GougingPlaces places = gouging_places(artifacts(), pipeline_.machine());
    val out = val::object();
    out.set("pairs", indices(places.pairs));
    out.set("places", Reals(precision)(places.places));
    out.set("angles", Reals(precision)(places.concave_deg));
    out.set("clearance", places.clearance_deg);
    return out;
  }
  val layers(bool planar, int precision) const {
    if (!pipeline_.is_done(planar ? Stage::metrics : Stage::layers)) return val::null();
    const LayerStack& stack = print(planar).layers;
    const PackedLayers packed = pack(stack);
    const Reals reals(precision);
    val out = val::object();
    out.set("count", static_cast<int>(stack.layers.size()));
    out.set("positions", reals(packed.positions));
    out.set("normals", reals(packed.normals));
    out.set("thickness", reals(packed.thickness));
    out.set("indices", indices(packed.triangles));
    out.set("sourceTets", indices(packed.source_tets));
    out.set("vertexOffsets", indices(packed.vertex_offsets));
    out.set("indexOffsets", indices(packed.index_offsets));
    out.set("isoValues", Reals(64)(packed.iso_values));
    out.set("isosurfaces", indices(packed.isosurfaces));
    out.set("partial", bytes(packed.partial));
    out.set("restsOn", indices(packed.rests_on));
    out.set("restsOnOffsets", indices(packed.rests_on_offsets));
    out.set("unsupportedArea", stack.unsupported_area);
    out.set("unsupportedPlaces", parsed(places_json(stack.unsupported_places)));
    out.set("droppedArea", stack.dropped_area);
    out.set("droppedPlaces", parsed(places_json(stack.dropped_places)));
    return out;
  }
  val waypoints(bool planar, int precision) const {
    if (!pipeline_.is_done(planar ? Stage::metrics : Stage::waypoints)) return val::null();
    const Waypoints& w = print(planar).waypoints;
    const Reals reals(precision);
    Values tilts(w.size());
    for (Index i = 0; i < w.size(); ++i)
      tilts[i] = degrees(std::atan2(w.normal.row(i).head<2>().norm(), w.normal(i, 2)));
    val out = val::object();
    out.set("count", w.size());
    out.set("positions", reals(w.position));
    out.set("normals", reals(w.normal));
    out.set("tangents", reals(w.tangent));
    out.set("widths", reals(w.width));
    out.set("heights", reals(w.height));
    out.set("extrusions", reals(w.extrusion));
    out.set("speeds", reals(w.speed));
    out.set("tilts", reals(tilts));
    out.set("components", indices(w.component));
    out.set("layers", indices(w.layer));
    out.set("paths", indices(w.path));
    out.set("kinds", bytes(w.kind));
    out.set("travels", bytes(w.travel));
    return out;
  }
  val motion(int precision) const {
    if (!pipeline_.is_done(Stage::motion)) return val::null();
    const MachineMotion& motion = artifacts().motion;
    const auto moves = static_cast<Eigen::Index>(motion.pose.size());
    Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> poses(moves, 6);
    Values times = Values::Zero(artifacts().curved.waypoints.size());
    double time = 0;
    for (Eigen::Index m = 0; m < moves; ++m) {
      const auto i = static_cast<std::size_t>(m);
      const MachinePose& pose = motion.pose[i];
      poses.row(m) << pose.xyz.transpose(), degrees(pose.a), degrees(pose.b), degrees(pose.c);
      time += motion.duration[m];
      if (motion.arrives[i]) times[motion.waypoint[i]] = time;
    }
    const Reals reals(precision);
    val out = val::object();
    out.set("partOffset",
            parsed(Json{motion.part_offset.x(), motion.part_offset.y(), motion.part_offset.z()}));
    out.set("poses", reals(poses));
    out.set("durations", reals(motion.duration));
    out.set("extrusions", reals(motion.extrusion));
    out.set("waypoints", indices(motion.waypoint));
    out.set("arrives", bytes(motion.arrives));
    out.set("times", reals(times));
    return out;
  }
  val metrics() const {
    if (!pipeline_.is_done(Stage::metrics)) return val::null();
    return parsed({{"curved", to_json(artifacts().curved_metrics)},
                   {"planar", to_json(artifacts().planar_metrics)}});
  }
  val plots() const {
    if (!pipeline_.is_done(Stage::metrics)) return val::null();
    Json json = Json::array();
    for (const SvgFile& file : artifacts().plots)
      json.push_back({{"name", file.name}, {"svg", file.text}});
    return parsed(json);
  }

  // Files.
  val list_exports() const {
    Json json = Json::array();
    const auto add = [&](const std::string& name, const Json& stage) {
      json.push_back({{"name", name}, {"stage", stage}, {"type", mime_type(name)}});
    };
    add("job.json", nullptr);
    add("report.json", nullptr);
    for (const StageRecord& record : pipeline_.stages())
      for (const OutputFile& file : stage_files(pipeline_, record.stage))
        add(file.name, std::string(stage_name(file.stage)));
    return parsed(json);
  }
  val export_file(const std::string& name) const {
    return guarded([&] {
      if (name == "job.json") return bytes(job_json(pipeline_));
      if (name == "report.json") return bytes(report());
      std::string names = "job.json, report.json";
      for (const StageRecord& record : pipeline_.stages())
        for (const OutputFile& file : stage_files(pipeline_, record.stage)) {
          if (file.name == name) return bytes(file.content());
          if (!file.name.starts_with("layers/")) names += ", " + file.name;
        }
      throw Error(ErrorKind::input, Stage::exporting, "export.unknown_file",
                  "There is no file \"" + name + "\" to export now",
                  "There are " + names + ", and layers/NNNN.ply once there are layers");
    });
  }

 private:
  const Artifacts& artifacts() const { return pipeline_.artifacts(); }
  const Print& print(bool planar) const { return planar ? artifacts().planar : artifacts().curved; }
  Directions directions(bool planar) const {
    return planar ? upright_directions(artifacts().rest.tet_count())
                  : artifacts().deformation.field.print_direction;
  }
  MachineProfile machine(const std::string& name) const {
    const auto own = profiles_.find(name);
    return own != profiles_.end() ? own->second : bundled_machine(name);
  }
  /// Defaults, but for the names of the files that are there.
  static Params with_files_of(const Params& params) {
    Params defaults;
    defaults.model = params.model;
    defaults.strength.load_case = params.strength.load_case;
    defaults.strength.stress_file = params.strength.stress_file;
    defaults.strength.critical_region = params.strength.critical_region;
    defaults.objectives.surface_region = params.objectives.surface_region;
    return defaults;
  }
  val set_region(const val& array, const std::string& name, Stage stage,
                 void (Pipeline::*give)(std::span<const std::byte>, std::string),
                 std::string& (*name_in)(Params&)) {
    return guarded([&] {
      const auto file = bytes_of(array);
      if (!file.empty()) read_region_file(file, name, stage);  // a fault in it is better said now
      Params params = given_;
      name_in(params) = name;
      (pipeline_.*give)(file, name);
      apply(params);
    });
  }

  /// Keeps the parameters once the pipeline has taken them.
  void apply(const Params& params) {
    pipeline_.set_params(params, machine(params.machine.machine));
    given_ = params;
  }
  std::string report() const {
    double seconds = 0;
    for (const StageRecord& record : pipeline_.stages())
      if (record.state == StageState::done) seconds += record.seconds;
    RunFigures figures;
    figures.model_file = pipeline_.model().name;
    figures.threads = engine_.ctx.pool.threads();
    figures.peak_memory_mb = memory_bytes() / (1 << 20);
    figures.total_seconds = seconds;
    return report_json(pipeline_, figures);
  }

  Engine& engine_;
  Pipeline pipeline_;
  Params given_;
  std::map<std::string, MachineProfile> profiles_;
};

}  // namespace

EMSCRIPTEN_BINDINGS(s3slicer) {
  emscripten::function("schema", &schema);
  emscripten::function("machineNames", &machine_names);
  emscripten::function("machineProfile", &machine_profile);
  emscripten::function("memoryUsed", &memory_used);
  emscripten::function("version", &version);

  emscripten::class_<Engine>("Engine")
      .constructor<int>()
      .function("cancelAddress", &Engine::cancel_address)
      .function("setCancel", &Engine::set_cancel)
      .function("inspect", &Engine::inspect);

  emscripten::class_<Slicer>("Slicer")
      .constructor<Engine&>()
      .function("setModel", &Slicer::set_model)
      .function("setStress", &Slicer::set_stress)
      .function("setLoadCase", &Slicer::set_load_case)
      .function("setCriticalRegion", &Slicer::set_critical_region)
      .function("setSurfaceRegion", &Slicer::set_surface_region)
      .function("setParams", &Slicer::set_params)
      .function("setMachineProfile", &Slicer::set_machine_profile)
      .function("givenParams", &Slicer::given_params)
      .function("params", &Slicer::params)
      .function("inputFiles", &Slicer::input_files)
      .function("inspect", &Slicer::inspect)
      .function("fileSurface", &Slicer::file_surface)
      .function("stages", &Slicer::stages)
      .function("advance", &Slicer::advance)
      .function("placement", &Slicer::placement)
      .function("surface", &Slicer::surface)
      .function("tets", &Slicer::tets)
      .function("stress", &Slicer::stress)
      .function("faces", &Slicer::faces)
      .function("deformation", &Slicer::deformation)
      .function("faceAngles", &Slicer::face_angles)
      .function("histogramData", &Slicer::histogram_data)
      .function("gouging", &Slicer::gouging)
      .function("layers", &Slicer::layers)
      .function("waypoints", &Slicer::waypoints)
      .function("motion", &Slicer::motion)
      .function("metrics", &Slicer::metrics)
      .function("plots", &Slicer::plots)
      .function("listExports", &Slicer::list_exports)
      .function("exportFile", &Slicer::export_file);
}

}  // namespace s3::wasm
