#include "fea/load_case.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/units.h"
#include "mesh/text_scanner.h"

namespace s3 {
namespace {

using Json = nlohmann::json;

constexpr double kLargest = 1e9;  // of any number in the file: far beyond what a part can bear
constexpr std::size_t kMostCases = 64, kMostConditions = 100, kMostShapes = 1000;
constexpr std::size_t kMostPoints = 100000;
constexpr double kPaperRatio = 1.2 / 3.5;  // Y2 / Y1, Sec. 5.2.3

/// What is read, and by which names its faults go.
struct Source {
  std::string_view file;
  Stage stage;
  std::string code, hint;
};

/// A value of the file with its place in it, for messages.
class Node {
 public:
  Node(const Json& json, const Source& source, std::string place)
      : json_(json), source_(source), place_(std::move(place)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorKind::input, source_.stage, source_.code,
                std::string(source_.file) + ": " +
                    (place_.empty() ? std::string("the file") : place_) + " " + what + ".",
                source_.hint);
  }

  const std::string& place() const { return place_; }
  bool is_object() const { return json_.is_object(); }
  bool is_array() const { return json_.is_array(); }
  bool is_null() const { return json_.is_null(); }
  bool is_text() const { return json_.is_string(); }
  bool is_true() const { return json_.is_boolean() && json_.get<bool>(); }
  const std::string& text() const { return json_.get_ref<const std::string&>(); }
  const Json& json() const { return json_; }

  /// An object with these keys only.
  void expect_keys(std::initializer_list<std::string_view> allowed) const {
    if (!json_.is_object()) fail("must be an object");
    for (const auto& [key, value] : json_.items()) {
      if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
      std::string list;
      for (const std::string_view name : allowed)
        list.append(list.empty() ? "" : ", ").append(name);
      fail("has the unknown key \"" + key.substr(0, 40) + "\"; known are " + list);
    }
  }
  std::optional<Node> find(const char* key) const {
    const auto found = json_.find(key);
    if (found == json_.end()) return std::nullopt;
    return Node(*found, source_, place_.empty() ? key : place_ + "." + key);
  }
  Node at(const char* key) const {
    const std::optional<Node> found = find(key);
    if (!found) fail("needs \"" + std::string(key) + "\"");
    return *found;
  }
  /// Members of an array of at most `most`.
  std::vector<Node> members(std::size_t most) const {
    if (!json_.is_array() || json_.empty()) fail("must be a list of at least one");
    if (json_.size() > most) fail("has more than " + std::to_string(most) + " members");
    std::vector<Node> nodes;
    for (std::size_t i = 0; i < json_.size(); ++i)
      nodes.emplace_back(json_[i], source_, place_ + "[" + std::to_string(i) + "]");
    return nodes;
  }

  double number() const {
    if (!json_.is_number()) fail("must be a number");
    const double value = json_.get<double>();
    if (!(std::abs(value) <= kLargest)) fail("is beyond ±1e9");
    return value;
  }
  double positive() const {
    const double value = number();
    if (!(value > 0)) fail("must be above 0");
    return value;
  }
  Vec3 vector() const {
    if (!json_.is_array() || json_.size() != 3) fail("must be a list of three numbers");
    Vec3 value;
    for (std::size_t i = 0; i < 3; ++i)
      value[static_cast<Eigen::Index>(i)] =
          Node(json_[i], source_, place_ + "[" + std::to_string(i) + "]").number();
    return value;
  }
  Vec3 direction() const {
    const Vec3 value = vector();
    if (!(value.norm() > 0)) fail("must not be 0, it is a direction");
    return value.normalized();
  }

 private:
  const Json& json_;
  const Source& source_;
  std::string place_;
};

Shape read_shape(const Node& node) {
  node.expect_keys({"plane", "half_space", "box", "sphere", "faces"});
  if (node.json().size() != 1) node.fail("must have exactly one shape");
  if (const auto plane = node.find("plane")) {
    plane->expect_keys({"point", "normal", "tolerance"});
    PlaneContact shape{plane->at("point").vector(), plane->at("normal").direction(), {}};
    if (const auto tolerance = plane->find("tolerance")) shape.tolerance = tolerance->positive();
    return shape;
  }
  if (const auto half = node.find("half_space")) {
    half->expect_keys({"point", "normal"});
    return HalfSpace{half->at("point").vector(), half->at("normal").direction()};
  }
  if (const auto box = node.find("box")) {
    box->expect_keys({"min", "max"});
    const BoxRegion shape{box->at("min").vector(), box->at("max").vector()};
    if ((shape.low.array() > shape.high.array()).any()) box->fail("has min above max");
    return shape;
  }
  if (const auto sphere = node.find("sphere")) {
    sphere->expect_keys({"center", "radius"});
    return SphereRegion{sphere->at("center").vector(), sphere->at("radius").positive()};
  }
  const Node faces = node.at("faces");
  faces.expect_keys({"points", "angle"});
  std::vector<Vec3> points;
  for (const Node& point : faces.at("points").members(kMostPoints))
    points.push_back(point.vector());
  PickedFaces shape{std::make_shared<const std::vector<Vec3>>(std::move(points)), 0};
  if (const auto angle = faces.find("angle")) {
    const double value = angle->number();
    if (!(value >= 0 && value <= 180)) angle->fail("must be from 0 to 180 degrees");
    shape.angle = radians(value);
  }
  return shape;
}

using NamedRegions = std::map<std::string, Region>;

/// @param named  the regions that a text may name; empty while they are read themselves
Region read_region(const Node& node, const NamedRegions& named) {
  Region region{node.place(), {}};
  const auto add = [&](const Node& member) {
    if (!member.is_text()) {
      region.shapes.push_back(read_shape(member));
      return;
    }
    if (member.text() == "plate") {
      region.shapes.emplace_back(PlateContact{});
      return;
    }
    const auto found = named.find(member.text());
    if (found == named.end())
      member.fail("names the region \"" + member.text().substr(0, 40) +
                  "\", which is neither \"plate\" nor under \"regions\"");
    region.shapes.insert(region.shapes.end(), found->second.shapes.begin(),
                         found->second.shapes.end());
  };
  if (node.is_array())
    for (const Node& member : node.members(kMostShapes)) add(member);
  else
    add(node);
  if (region.shapes.size() > kMostShapes)
    node.fail("has more than " + std::to_string(kMostShapes) + " shapes");
  if (node.is_text()) region.name = node.text();
  return region;
}

NamedRegions read_regions(const Node& root) {
  NamedRegions regions;
  const auto node = root.find("regions");
  if (!node) return regions;
  if (!node->is_object()) node->fail("must be an object");
  for (const auto& [name, value] : node->json().items()) {
    if (name == "plate") node->fail("must not name \"plate\", which is the contact with the plate");
    Region region = read_region(node->at(name.c_str()), {});
    region.name = name;
    regions.emplace(name, std::move(region));
  }
  return regions;
}

Displacement read_fixed(const Node& node) {
  Displacement held;
  if (node.is_true()) {
    held.value.fill(0.0);
    return held;
  }
  if (!node.is_text() || node.text().empty())
    node.fail("must be true or name axes, as \"z\" or \"xy\"");
  for (const char axis : node.text()) {
    if (axis < 'x' || axis > 'z') node.fail("must name axes out of x, y and z");
    held.value[static_cast<std::size_t>(axis - 'x')] = 0.0;
  }
  return held;
}

Displacement read_displacement(const Node& node) {
  Displacement moved;
  const std::vector<Node> axes = node.members(3);
  if (axes.size() != 3) node.fail("must have three members");
  bool any = false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (axes[i].is_null()) continue;
    moved.value[i] = axes[i].number();
    any = true;
  }
  if (!any) node.fail("leaves every axis free");
  return moved;
}

Condition read_condition(const Node& node, const NamedRegions& named, LoadCases& file) {
  node.expect_keys({"region", "fixed", "displacement", "force", "pressure", "gravity"});
  if (node.json().size() != (node.find("gravity") ? 1U : 2U))
    node.fail(
        "must have a region and one of fixed, displacement, force and pressure, or gravity "
        "alone");
  if (const auto gravity = node.find("gravity")) return {0, Gravity{gravity->vector()}};
  const std::size_t region = file.regions.size();
  file.regions.push_back(read_region(node.at("region"), named));
  if (const auto fixed = node.find("fixed")) return {region, read_fixed(*fixed)};
  if (const auto moved = node.find("displacement")) return {region, read_displacement(*moved)};
  if (const auto force = node.find("force")) return {region, TotalForce{force->vector()}};
  return {region, Pressure{node.at("pressure").number()}};
}

std::vector<Condition> read_conditions(const Node& parent, const NamedRegions& named,
                                       LoadCases& file) {
  std::vector<Condition> conditions;
  if (const auto list = parent.find("conditions"))
    for (const Node& node : list->members(kMostConditions))
      conditions.push_back(read_condition(node, named, file));
  return conditions;
}

OrthotropicConstants read_printed(const Node& node) {
  node.expect_keys({"young", "poisson", "shear"});
  return {node.at("young").vector(), node.at("poisson").vector(), node.at("shear").vector()};
}

Material bundled_material(const Node& node) {
  std::string known;
  for (const Material& material : bundled_materials()) {
    if (lower_case(material.name) == lower_case(node.text())) return material;
    known.append(known.empty() ? "" : ", ").append(material.name);
  }
  node.fail("is \"" + node.text().substr(0, 40) + "\"; bundled materials are " + known);
}

Material read_material(const Node& root) {
  const auto node = root.find("material");
  if (!node) return bundled_materials().front();
  if (node->is_text()) return bundled_material(*node);
  node->expect_keys({"young", "poisson", "density", "printed"});
  Material material;
  material.name = material.source = "the load case";
  material.young = node->at("young").positive();
  material.poisson = node->at("poisson").number();
  if (const auto density = node->find("density")) material.density = density->positive();
  isotropic_stiffness(material.young, material.poisson);  // says what is wrong
  const auto printed = node->find("printed");
  material.printed =
      printed ? read_printed(*printed)
              : bead_constants(material.young, kPaperRatio * material.young, material.poisson);
  orthotropic_stiffness(material.printed);
  return material;
}

void read_cases(const Node& root, const NamedRegions& named, LoadCases& file) {
  const std::vector<Condition> common = read_conditions(root, named, file);
  std::vector<LoadCase>& cases = file.cases;
  if (const auto list = root.find("cases")) {
    for (const Node& node : list->members(kMostCases)) {
      node.expect_keys({"name", "conditions"});
      LoadCase one{node.place(), common};
      if (const auto name = node.find("name")) {
        if (!name->is_text()) name->fail("must be a text");
        one.name = name->text();
      }
      const std::vector<Condition> own = read_conditions(node, named, file);
      one.conditions.insert(one.conditions.end(), own.begin(), own.end());
      cases.push_back(std::move(one));
    }
  } else {
    cases.push_back({"load", common});
  }
  for (const LoadCase& one : cases)
    if (one.conditions.empty()) root.fail("has no conditions for the case \"" + one.name + "\"");
}

void check_density(const Node& root, const LoadCases& file) {
  for (const LoadCase& one : file.cases)
    for (const Condition& condition : one.conditions)
      if (std::holds_alternative<Gravity>(condition.action) && !(file.material.density > 0))
        root.fail("has gravity, but its material has no density");
}

Json parse(std::span<const std::byte> bytes, const Source& source) {
  try {
    return Json::parse(as_text(bytes));
  } catch (const Json::exception& error) {
    throw Error(
        ErrorKind::input, source.stage, source.code,
        std::string(source.file) + " is no JSON: " + error.what() + ".",
        "Numbers must be finite and written in full; see core/fea/load_case.h for the form.");
  }
}

}  // namespace

LoadCases read_load_cases(std::span<const std::byte> bytes, std::string_view file_name) {
  const Source source{file_name, Stage::fea, "fea.bad_load_case",
                      "The form of a load case is described in core/fea/load_case.h; start from "
                      "one of models/*.load.json."};
  const Json json = parse(bytes, source);
  const Node root(json, source, "");
  root.expect_keys({"material", "regions", "conditions", "cases", "about"});
  const NamedRegions named = read_regions(root);
  LoadCases file{read_material(root), {}, {}};
  read_cases(root, named, file);
  check_density(root, file);
  return file;
}

Region read_region_file(std::span<const std::byte> bytes, std::string_view file_name, Stage stage) {
  const Source source{file_name, stage, std::string(stage_name(stage)) + ".bad_region",
                      "The form of a region file is described in core/fea/load_case.h."};
  const Json json = parse(bytes, source);
  const Node root(json, source, "");
  root.expect_keys({"region", "regions", "about"});
  Region region = read_region(root.at("region"), read_regions(root));
  region.name = "of " + std::string(file_name);
  return region;
}

}  // namespace s3
