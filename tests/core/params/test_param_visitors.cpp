#include "params/param_visitors.h"

#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace {

struct BeadParams {
  double width = 0.8;
  double angle = 0.1 + 0.2;  // a number without a short decimal form
  int rings = 3;
  bool spiral = false;
  std::string order = "outside";
};

template <class Visitor>
void describe(Visitor& v, BeadParams& p) {
  v(p.width, s3::ParamInfo{.key = "bead.width",
                           .label = "Width",
                           .unit = "mm",
                           .doc = "Bead width.",
                           .min = 0.1,
                           .max = 5,
                           .stage = s3::Stage::toolpaths});
  v(p.angle, s3::ParamInfo{.key = "bead.start.angle",
                           .label = "Angle",
                           .unit = "deg",
                           .doc = "Where it starts.",
                           .stage = s3::Stage::waypoints,
                           .advanced = true});
  v(p.rings, s3::ParamInfo{.key = "bead.rings",
                           .label = "Rings",
                           .unit = "",
                           .doc = "How many rings.",
                           .min = 1,
                           .max = 9,
                           .stage = s3::Stage::toolpaths});
  v(p.spiral, s3::ParamInfo{.key = "spiral",
                            .label = "Spiral",
                            .unit = "",
                            .doc = "One path.",
                            .stage = s3::Stage::toolpaths});
  v(p.order, s3::ParamInfo{.key = "bead.order",
                           .label = "Order",
                           .unit = "",
                           .doc = "First ring.",
                           .choices = {"outside", "inside"},
                           .stage = s3::Stage::toolpaths});
}

s3::Error error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const s3::Error& error) {
    return error;
  }
  FAIL("no error was thrown");
  return s3::Error(s3::ErrorKind::slicing, s3::Stage::mesh, "", "");
}

bool mentions(const s3::Error& error, const std::string& text) {
  return (std::string(error.what()) + " " + error.hint).find(text) != std::string::npos;
}

}  // namespace

TEST_CASE("parameters written as JSON and read back are the same to the last bit") {
  BeadParams written;
  written.width = 1.0 / 3;
  written.rings = 7;
  written.spiral = true;
  written.order = "inside";
  BeadParams read;
  s3::from_json(s3::list_params(read), s3::to_json(s3::list_params(written)), "job.json");
  CHECK(read.width == written.width);
  CHECK(read.angle == written.angle);
  CHECK(read.rings == 7);
  CHECK(read.spiral);
  CHECK(read.order == "inside");
  CHECK(s3::diff(s3::list_params(read), s3::list_params(written)).empty());
}

TEST_CASE("JSON nests at the dots of the keys") {
  BeadParams params;
  const auto json = nlohmann::json::parse(s3::to_json(s3::list_params(params)));
  CHECK(json["bead"]["width"] == 0.8);
  CHECK(json["bead"]["start"]["angle"] == 0.1 + 0.2);
  CHECK(json["spiral"] == false);
}

TEST_CASE("a JSON file changes what it names and nothing else") {
  BeadParams params;
  s3::from_json(s3::list_params(params), R"({"bead": {"rings": 5}})", "job.json");
  CHECK(params.rings == 5);
  CHECK(params.width == 0.8);
}

TEST_CASE("an unknown key is an error that names the file, the key and the nearest known key") {
  BeadParams params;
  const auto list = s3::list_params(params);
  const auto typo = error_of([&] { s3::from_json(list, R"({"bead": {"widht": 1}})", "my.json"); });
  CHECK(typo.kind == s3::ErrorKind::input);
  CHECK(typo.code == "params.unknown_key");
  CHECK(mentions(typo, "my.json"));
  CHECK(mentions(typo, "bead.widht"));
  CHECK(mentions(typo, "bead.width"));
  const auto group = error_of([&] { s3::set_by_key(list, "path.rings", "2"); });
  CHECK(mentions(group, "bead.rings"));
  CHECK(error_of([&] { s3::from_json(list, R"({"bead": 4})", ""); }).code == "params.unknown_key");
  CHECK(error_of([&] { s3::from_json(list, R"({"spiral": {"x": 4}})", ""); }).code ==
        "params.wrong_type");
}

TEST_CASE(
    "a value outside its range is an error that names key, value and range, and nothing is set") {
  BeadParams params;
  const auto list = s3::list_params(params);
  const auto error =
      error_of([&] { s3::from_json(list, R"({"bead": {"rings": 4, "width": 7.5}})", ""); });
  CHECK(error.code == "params.out_of_range");
  CHECK(mentions(error, "bead.width"));
  CHECK(mentions(error, "7.5"));
  CHECK(mentions(error, "0.1 to 5 mm"));
  CHECK(params.rings == 3);
  CHECK(mentions(error_of([&] { s3::set_by_key(list, "bead.order", "up"); }), "outside, inside"));
  s3::set_by_key(list, "bead.width", "5");
  CHECK(params.width == 5);
  CHECK_THROWS_AS(s3::set_by_key(list, "bead.width", "5.0000001"), s3::Error);
}

TEST_CASE("values of the wrong type are errors") {
  BeadParams params;
  const auto list = s3::list_params(params);
  for (const char* json : {R"({"bead": {"width": "1"}})", R"({"bead": {"rings": 2.5}})",
                           R"({"spiral": 1})", R"({"bead": {"order": 3}})",
                           R"({"bead": {"rings": 1e300}})", R"({"bead": {"width": null}})"})
    CHECK(error_of([&] { s3::from_json(list, json, ""); }).code == "params.wrong_type");
  for (const char* json : {"", "[]", "{", "3", "{\"bead\":", "\xff\xfe"})
    CHECK(error_of([&] { s3::from_json(list, json, ""); }).code == "params.bad_json");
  for (const char* text : {"", "x", "1x", "nan", "inf", "1e999"})
    CHECK(error_of([&] { s3::set_by_key(list, "bead.width", text); }).code == "params.wrong_type");
  CHECK_THROWS_AS(s3::set_by_key(list, "spiral", "maybe"), s3::Error);
}

TEST_CASE("the schema says type, unit, range, default, choices and stage of every key") {
  BeadParams params;
  const auto schema = nlohmann::json::parse(s3::json_schema(s3::list_params(params)));
  const auto& width = schema["properties"]["bead"]["properties"]["width"];
  CHECK(width["key"] == "bead.width");
  CHECK(width["type"] == "number");
  CHECK(width["unit"] == "mm");
  CHECK(width["minimum"] == 0.1);
  CHECK(width["maximum"] == 5);
  CHECK(width["default"] == 0.8);
  CHECK(width["stage"] == "toolpaths");
  CHECK(width["x-advanced"] == false);
  const auto& angle = schema["properties"]["bead"]["properties"]["start"]["properties"]["angle"];
  CHECK_FALSE(angle.contains("minimum"));
  CHECK(angle["x-advanced"] == true);
  CHECK(schema["properties"]["bead"]["properties"]["order"]["enum"].size() == 2);
  CHECK(schema["properties"]["spiral"]["type"] == "boolean");
  CHECK(schema["properties"]["bead"]["properties"]["rings"]["type"] == "integer");
}

TEST_CASE("diff names the parameters that changed") {
  BeadParams a, b;
  b.rings = 4;
  b.order = "inside";
  const auto list = s3::list_params(a);
  const auto changed = s3::diff(list, s3::list_params(b));
  REQUIRE(changed.size() == 2);
  CHECK(list.params()[changed[0]].info.key == "bead.rings");
  CHECK(list.params()[changed[1]].info.key == "bead.order");
}
