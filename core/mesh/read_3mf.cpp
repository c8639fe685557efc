// The format: 3MF Consortium, "3D Manufacturing Format: Core Specification", version 1.3, and
// "Production Extension", version 1.1.
#include "mesh/read_3mf.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "base/error.h"
#include "mesh/text_scanner.h"
#include "mesh/write_mesh.h"
#include "mesh/xml_reader.h"
#include "mesh/zip_archive.h"

namespace s3 {

namespace {

constexpr std::string_view kProductionNamespace =
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
constexpr std::string_view kMaterialNamespace =
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";

constexpr int kDeepestNesting = 64;
// Components may repeat what the file holds this often, or up to so many vertices and triangles.
constexpr double kMostRepetition = 100, kAlwaysFine = 2e6;

struct Unit {
  std::string_view name;
  double mm;
};
constexpr Unit kUnits[] = {{"millimeter", 1}, {"micron", 1e-3}, {"centimeter", 10},
                           {"inch", 25.4},    {"foot", 304.8},  {"meter", 1000}};

struct Transform {
  Mat3 linear = Mat3::Identity();
  Vec3 shift = Vec3::Zero();  // mm

  Vec3 operator()(const Vec3& p) const { return linear * p + shift; }
  Transform operator*(const Transform& inner) const {
    return {linear * inner.linear, linear * inner.shift + shift};
  }
};

struct Object;

struct Component {
  const Object* object;
  Transform transform;
};

/// A mesh or components, never both.
struct Object {
  std::string name, type;
  std::vector<double> coordinates;  // mm
  std::vector<Index> corners;
  std::vector<Component> components;
  double expanded = 1;  // vertices, triangles and components, each as often as it is repeated
  int nesting = 0;
};

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, std::string_view file_name)
      : archive_(bytes, file_name), file_name_(file_name) {}

  ModelFile read() {
    read_model_part(root_path(), true);
    build();
    if (!coordinates_.empty()) {
      model_.surface.vertices = Eigen::Map<const Points>(
          coordinates_.data(), static_cast<Eigen::Index>(coordinates_.size() / 3), 3);
      model_.surface.triangles = Eigen::Map<const Triangles>(
          corners_.data(), static_cast<Eigen::Index>(corners_.size() / 3), 3);
    }
    if (!model_.surface.vertices.allFinite()) fail("the transforms give infinite coordinates");
    return std::move(model_);
  }

 private:
  struct Item {
    const Object* object;
    Transform transform;
  };

  // One XML file of the archive while it is read.
  struct Part {
    std::string path, place, text;
    XmlReader xml;
    bool is_root;
    double unit = 1;                // mm
    std::string prefix;             // of the core's elements, with its colon
    std::string production_prefix;  // of p:path, with its colon; empty without the extension
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file",
                std::string(file_name_) + ": " + what, "Export the model again, or as STL");
  }

  void warn(const char* code, const std::string& what) {
    model_.warnings.push_back({code, std::string(file_name_) + " " + what, {}});
  }

  static std::string without_slash(std::string_view path) {
    return std::string(path.substr(path.starts_with('/') ? 1 : 0));
  }

  std::string root_path() {
    std::string path = "3D/3dmodel.model";
    if (!archive_.has("_rels/.rels")) return path;
    const std::string text = archive_.take("_rels/.rels");
    XmlReader xml(text, file_name_);
    while (xml.next())
      if (!xml.closes() && xml["Type"].ends_with("/3dmodel"))
        path = without_slash(decoded_xml(xml["Target"]));
    return path;
  }

  void read_model_part(const std::string& path, bool is_root) {
    read_paths_.insert(path);
    std::string text = archive_.take(path);
    std::string place = std::string(file_name_) + " (" + path + ")";
    Part part{path, place, text, XmlReader({}, {}), is_root, 1, {}, {}};
    part.xml = XmlReader(part.text, part.place);
    XmlReader& xml = part.xml;
    if (!xml.next()) xml.fail("no <model>");
    take_model_attributes(part);
    xml.for_each_child([&] {
      if (is_core(part, "resources"))
        take_resources(part);
      else if (is_core(part, "build") && part.is_root)
        take_build(part);
      else
        xml.skip_element();
    });
  }

  bool is_core(const Part& part, std::string_view name) const {
    const std::string_view whole = part.xml.name();
    return whole.starts_with(part.prefix) && whole.substr(part.prefix.size()) == name;
  }

  void take_model_attributes(Part& part) {
    XmlReader& xml = part.xml;
    const std::string_view name = xml.name();
    const std::size_t colon = name.find(':');
    if (name.substr(colon == std::string_view::npos ? 0 : colon + 1) != "model")
      xml.fail(std::string(name.substr(0, 40)) + " where the element model should be");
    if (colon != std::string_view::npos) part.prefix = name.substr(0, colon + 1);
    for (const XmlReader::Attribute& a : xml.attributes())
      if (a.value == kProductionNamespace && a.name.starts_with("xmlns:"))
        part.production_prefix = std::string(a.name.substr(6)) + ":";
    part.unit = take_unit(part);
    warn_about_extensions(part);
  }

  double take_unit(const Part& part) {
    const std::string_view name = part.xml["unit"];
    if (name.empty()) return 1;
    const Unit* unit = std::find_if(std::begin(kUnits), std::end(kUnits),
                                    [&](const Unit& u) { return u.name == name; });
    if (unit == std::end(kUnits))
      part.xml.fail("'" + std::string(name.substr(0, 40)) + "' is no unit of 3MF");
    if (unit->mm != 1 && !units_warned_) {
      units_warned_ = true;
      std::string factor;
      append_number(factor, unit->mm);
      warn("mesh.units", "gives its lengths in " + std::string(name) +
                             "; they were converted to mm, times " + factor +
                             ". If the part has the wrong size, set input.scale");
    }
    return unit->mm;
  }

  void warn_about_extensions(const Part& part) {
    std::string_view prefixes = part.xml["requiredextensions"];
    for (std::string_view word = take_word(prefixes); !word.empty(); word = take_word(prefixes)) {
      const std::string_view space = part.xml["xmlns:" + std::string(word)];
      if (space == kProductionNamespace || space == kMaterialNamespace) continue;
      if (extensions_warned_.insert(std::string(space)).second)
        warn("mesh.3mf_extension", "needs the extension " + decoded_xml(space.substr(0, 200)) +
                                       ", which is not known here; what it adds is left out: "
                                       "look at the result, or export the model as STL");
    }
  }

  void take_resources(Part& part) {
    part.xml.for_each_child([&] {
      if (is_core(part, "object"))
        take_object(part);
      else
        part.xml.skip_element();
    });
  }

  std::int64_t take_id(const XmlReader& xml, std::string_view attribute) const {
    const std::optional<std::int64_t> id = parse_integer(xml[attribute]);
    if (!id) xml.fail("no usable " + std::string(attribute));
    return *id;
  }

  void take_object(Part& part) {
    XmlReader& xml = part.xml;
    const auto [entry, is_new] = objects_.try_emplace({part.path, take_id(xml, "id")});
    if (!is_new) xml.fail("object " + std::string(xml["id"].substr(0, 40)) + " is there twice");
    Object& object = entry->second;
    object.name = decoded_xml(xml["name"].substr(0, 1000));
    object.type = xml["type"].empty() ? "model" : xml["type"];
    unfinished_ = &object;
    xml.for_each_child([&] {
      if (is_core(part, "mesh"))
        take_mesh(part, object);
      else if (is_core(part, "components"))
        take_components(part, object);
      else
        xml.skip_element();
    });
    unfinished_ = nullptr;
    if (!object.corners.empty() && !object.components.empty())
      xml.fail("an object with both a mesh and components");
    const double own = static_cast<double>(object.coordinates.size() + object.corners.size()) / 3;
    object.expanded += own;
    held_ += own;
    for (const Component& c : object.components) {
      object.expanded += c.object->expanded;
      object.nesting = std::max(object.nesting, c.object->nesting + 1);
    }
    if (object.nesting > kDeepestNesting) xml.fail("components within components too often");
  }

  void take_mesh(Part& part, Object& object) {
    XmlReader& xml = part.xml;
    xml.for_each_child([&] {
      if (is_core(part, "vertices")) {
        xml.for_each_child([&] {
          if (is_core(part, "vertex")) take_vertex(part, object);
          xml.skip_element();
        });
      } else if (is_core(part, "triangles")) {
        xml.for_each_child([&] {
          if (is_core(part, "triangle")) take_triangle(part, object);
          xml.skip_element();
        });
      } else {
        xml.skip_element();
      }
    });
    const std::size_t vertices = object.coordinates.size() / 3;
    for (const Index corner : object.corners)
      if (static_cast<std::size_t>(corner) >= vertices)
        xml.fail("a triangle names vertex " + std::to_string(corner) + ", the object has " +
                 std::to_string(vertices));
  }

  void take_vertex(const Part& part, Object& object) const {
    for (const std::string_view axis : {"x", "y", "z"}) {
      const std::optional<double> value = parse_double(part.xml[axis]);
      if (!value)
        part.xml.fail("a vertex with " + std::string(axis) + " = '" +
                      std::string(part.xml[axis].substr(0, 40)) + "'");
      object.coordinates.push_back(*value * part.unit);
    }
  }

  void take_triangle(const Part& part, Object& object) const {
    for (const std::string_view corner : {"v1", "v2", "v3"}) {
      const std::optional<std::int64_t> value = parse_integer(part.xml[corner]);
      if (!value || *value < 0 || *value > std::numeric_limits<Index>::max())
        part.xml.fail("a triangle with " + std::string(corner) + " = '" +
                      std::string(part.xml[corner].substr(0, 40)) + "'");
      object.corners.push_back(static_cast<Index>(*value));
    }
  }

  // "m00 m01 m02 m10 … m32": row vectors times a 4×3 matrix, so its first three rows are the
  // columns of ours.
  Transform take_transform(const Part& part) const {
    std::string_view text = part.xml["transform"];
    Transform transform;
    if (trimmed(text).empty()) return transform;
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 3; ++column) {
        const std::string_view word = take_word(text);
        const std::optional<double> value = parse_double(word);
        if (!value)
          part.xml.fail("a transform with '" + std::string(word.substr(0, 40)) +
                        "' where a number should be");
        (row < 3 ? transform.linear(column, row) : transform.shift[column]) =
            row < 3 ? *value : *value * part.unit;
      }
    const double determinant = transform.linear.determinant();
    if (!(std::abs(determinant) > 0) || !std::isfinite(determinant))
      part.xml.fail("a transform that leaves no volume");
    return transform;
  }

  // The object that a component or build item names; other files of the archive are read when they
  // are first named.
  const Object* take_reference(Part& part) {
    std::string path = part.path;
    if (!part.production_prefix.empty()) {
      const std::string_view other = part.xml[part.production_prefix + "path"];
      if (!other.empty()) path = without_slash(decoded_xml(other));
    }
    if (path != part.path) {
      if (!part.is_root) part.xml.fail("only the archive's root may name other files");
      if (read_paths_.count(path) == 0) {
        const Object* unfinished = std::exchange(unfinished_, nullptr);
        read_model_part(path, false);
        unfinished_ = unfinished;
      }
    }
    const std::int64_t id = take_id(part.xml, "objectid");
    const auto found = objects_.find({path, id});
    if (found == objects_.end() || &found->second == unfinished_)
      part.xml.fail("object " + std::to_string(id) + " is named before it is there");
    return &found->second;
  }

  void take_components(Part& part, Object& object) {
    part.xml.for_each_child([&] {
      if (is_core(part, "component")) {
        const Transform transform = take_transform(part);
        object.components.push_back({take_reference(part), transform});
      }
      part.xml.skip_element();
    });
  }

  void take_build(Part& part) {
    part.xml.for_each_child([&] {
      if (is_core(part, "item")) {
        const Transform transform = take_transform(part);
        items_.push_back({take_reference(part), transform});
      }
      part.xml.skip_element();
    });
  }

  void build() {
    if (items_.empty()) take_all_objects();
    double expanded = 0;
    for (const Item& item : items_) expanded += item.object->expanded;
    if (expanded > std::min(std::max(kAlwaysFine, kMostRepetition * held_),
                            double{std::numeric_limits<Index>::max()}))
      fail("components repeat the " + std::to_string(static_cast<std::int64_t>(held_)) +
           " vertices and triangles of the file too often");
    std::size_t supports = 0;
    for (const Item& item : items_) add(*item.object, item.transform, item.object->name, supports);
    if (supports > 0)
      warn("mesh.3mf_supports",
           "holds " + std::to_string(supports) + " support objects, which are left out");
  }

  // A file without build items is a library: each object that is no component of another.
  void take_all_objects() {
    std::set<const Object*> used;
    for (const auto& [key, object] : objects_)
      for (const Component& c : object.components) used.insert(c.object);
    for (const auto& [key, object] : objects_)
      if (used.count(&object) == 0) items_.push_back({&object, {}});
    if (!items_.empty())
      warn("mesh.3mf_no_build",
           "names nothing to build; each of its objects is taken once, as it lies");
  }

  void add(const Object& object, const Transform& transform, const std::string& name,
           std::size_t& supports) {
    if (object.type == "support" || object.type == "solidsupport") {
      ++supports;
      return;
    }
    for (const Component& c : object.components)
      add(*c.object, transform * c.transform, c.object->name.empty() ? name : c.object->name,
          supports);
    if (object.corners.empty()) return;
    const auto first = static_cast<Index>(coordinates_.size() / 3);
    const auto part = static_cast<Index>(model_.part_names.size());
    model_.part_names.push_back(name);
    for (std::size_t at = 0; at < object.coordinates.size(); at += 3) {
      const Vec3 p = transform(Eigen::Map<const Vec3>(object.coordinates.data() + at));
      coordinates_.insert(coordinates_.end(), p.data(), p.data() + 3);
    }
    const bool mirrored = transform.linear.determinant() < 0;
    for (std::size_t at = 0; at < object.corners.size(); at += 3) {
      const Index* c = object.corners.data() + at;
      corners_.insert(corners_.end(),
                      {first + c[0], first + c[mirrored ? 2 : 1], first + c[mirrored ? 1 : 2]});
      model_.part_of_triangle.push_back(part);
    }
  }

  ZipArchive archive_;
  std::string_view file_name_;
  std::map<std::pair<std::string, std::int64_t>, Object> objects_;  // by file and number
  std::set<std::string> read_paths_, extensions_warned_;
  const Object* unfinished_ = nullptr;
  bool units_warned_ = false;
  double held_ = 0;  // vertices and triangles in the file
  std::vector<Item> items_;
  ModelFile model_;
  std::vector<double> coordinates_;
  std::vector<Index> corners_;
};

}  // namespace

ModelFile read_3mf(std::span<const std::byte> bytes, std::string_view file_name) {
  return Reader(bytes, file_name).read();
}

}  // namespace s3
