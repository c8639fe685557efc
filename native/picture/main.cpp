// s3picture: draws an output folder of s3slice into one PNG, several views side by side.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string_view>

#include "base/error.h"
#include "base/units.h"
#include "export/layers_ply.h"
#include "export/waypoint_csv.h"
#include "mesh/read_vtu.h"
#include "picture/rasterizer.h"
#include "picture/scene.h"
#include "scalar_field/scalar_field.h"

namespace {

using namespace s3;
namespace fs = std::filesystem;

struct View {
  const char* name;
  double azimuth_deg, elevation_deg;
};
constexpr View kViews[] = {{"iso", 35, 25},  {"front", 0, 0},  {"right", 90, 0},  {"back", 180, 0},
                           {"left", 270, 0}, {"top", 0, 89.9}, {"below", 35, -30}};

struct Arguments {
  std::string outdir, target = "picture.png", show = "layers";
  std::vector<std::string> views = {"iso", "front"};
  int size = 900;
  PictureOptions options;
};

std::string_view text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<std::byte> read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw Error(ErrorKind::input, Stage::exporting, "picture.missing",
                path.string() + " cannot be read", "Give an output folder of s3slice run");
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

LayerStack read_layers(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".ply") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  LayerStack stack;
  for (const fs::path& file : files) {
    stack.layers.push_back(read_layer_ply(read_file(file), file.filename().string()));
    stack.layers.back().layer = static_cast<Index>(stack.layers.size());
  }
  return stack;
}

// Boundary faces that overhang their layer by more than 45°, as the report counts them.
std::vector<char> overhangs(const TetMesh& mesh, const ScalarField& field) {
  std::vector<char> marked(static_cast<std::size_t>(mesh.boundary_faces.rows()), 0);
  const std::vector<char> plate = plate_faces(mesh);
  for (Eigen::Index f = 0; f < mesh.boundary_faces.rows(); ++f) {
    const auto at = static_cast<std::size_t>(f);
    const Vec3 n = triangle_normal_2a(mesh.vertices, mesh.boundary_faces.row(f)).normalized();
    const Vec3 d = field.print_direction.row(mesh.boundary_face_tet[at]);
    marked[at] = !plate[at] && n.dot(d) + std::sin(radians(45)) < 0;
  }
  return marked;
}

void draw(const Arguments& arguments) {
  std::function<void(Rasterizer&)> scene;
  Box box;
  if (arguments.show == "surface") {
    const VtuFile vtu =
        read_vtu(read_file(fs::path(arguments.outdir) / "fields.vtu"), "fields.vtu");
    const TetMesh mesh = make_tet_mesh(vtu.vertices, vtu.tets);
    const auto& values = vtu.point_data.at("G").values;
    const ScalarField field = make_scalar_field(
        mesh, Eigen::Map<const Values>(values.data(), static_cast<Eigen::Index>(values.size())));
    box = bounding_box(mesh.vertices);
    scene = [mesh, field](Rasterizer& target) {
      draw_surface(target, mesh, field.value, overhangs(mesh, field));
    };
  } else if (arguments.show == "toolpaths") {
    Waypoints waypoints =
        read_waypoint_csv(text_of(read_file(fs::path(arguments.outdir) / "waypoints.csv")));
    box = bounding_box(waypoints.position);
    scene = [waypoints, &arguments](Rasterizer& target) {
      draw_toolpaths(target, waypoints, arguments.options);
    };
  } else {
    LayerStack stack = read_layers(fs::path(arguments.outdir) / "layers");
    if (stack.layers.empty())
      throw Error(ErrorKind::input, Stage::exporting, "picture.missing",
                  arguments.outdir + " has no layers", "Run s3slice first");
    box = bounding_box(stack.layers.front().surface.vertices);
    for (const Layer& layer : stack.layers) {
      const Box b = bounding_box(layer.surface.vertices);
      box.min = box.min.cwiseMin(b.min);
      box.max = box.max.cwiseMax(b.max + Vec3(0, 0, arguments.options.explode * layer.layer));
    }
    scene = [stack, &arguments](Rasterizer& target) {
      draw_layers(target, stack, arguments.options);
    };
  }

  const int size = arguments.size;
  Image picture(size * static_cast<int>(arguments.views.size()), size);
  for (std::size_t i = 0; i < arguments.views.size(); ++i) {
    const View* view = std::find_if(std::begin(kViews), std::end(kViews),
                                    [&](const View& v) { return arguments.views[i] == v.name; });
    const Camera camera = Camera::orbit(0.5 * (box.min + box.max), radians(view->azimuth_deg),
                                        radians(view->elevation_deg), 0.52 * box.diagonal());
    Rasterizer target(size, size, camera);
    scene(target);
    picture.paste(target.finish(), size * static_cast<int>(i), 0);
  }
  write_png(picture, arguments.target);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Draws an output folder of s3slice into a PNG");
  app.add_option("outdir", arguments.outdir, "output folder of s3slice run")->required();
  app.add_option("-o,--output", arguments.target, "the PNG");
  app.add_option("--show", arguments.show, "what to draw")
      ->check(CLI::IsMember({"layers", "toolpaths", "surface"}));
  std::vector<std::string> names;
  for (const View& view : kViews) names.emplace_back(view.name);
  app.add_option("--views", arguments.views, "views side by side")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  app.add_option("--size", arguments.size, "pixels of one view")->check(CLI::Range(64, 4096));
  app.add_option("--first", arguments.options.first, "draw from this share of the layers")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--last", arguments.options.last, "draw up to this share of the layers")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--explode", arguments.options.explode, "mm to pull successive layers apart");
  app.add_option("--cut", arguments.options.cut,
                 "mm: leave out what lies in front of y = CUT, to look inside");
  CLI11_PARSE(app, argc, argv);
  try {
    draw(arguments);
  } catch (const Error& error) {
    std::fprintf(stderr, "s3picture: %s. %s\n", error.what(), error.hint.c_str());
    return error.kind == ErrorKind::input ? 2 : 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "s3picture: %s\n", error.what());
    return 3;
  }
  return 0;
}
