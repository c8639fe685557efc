#include "pipeline/params.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/units.h"
#include "params/param_visitors.h"

TEST_CASE("every parameter of the contract exists, with its default") {
  s3::Params params;
  const auto schema = nlohmann::json::parse(s3::json_schema(s3::list_params(params)));
  const auto leaf = [&](const std::string& key) {
    std::string path = "/properties/" + key;
    for (std::size_t dot; (dot = path.find('.')) != std::string::npos;)
      path.replace(dot, 1, "/properties/");
    return schema.at(nlohmann::json::json_pointer(path));
  };
  const nlohmann::json defaults = {{"input.up", "z"},
                                   {"input.scale", 1.0},
                                   {"mesh.target_tets", 100000},
                                   {"objectives.alpha", 45.0},
                                   {"objectives.beta", 10.0},
                                   {"objectives.gamma", 20.0},
                                   {"strength.stress_file", ""},
                                   {"strength.load_case", ""},
                                   {"strength.critical_ratio", 0.3},
                                   {"strength.critical_region", ""},
                                   {"objectives.surface_region", ""},
                                   {"deform.method", "refined"},
                                   {"deform.rigidity", 1.0},
                                   {"deform.scale_compatibility", 6.0}};
  for (const auto& item : defaults.items())
    CHECK_MESSAGE(leaf(item.key())["default"] == item.value(), item.key());
  for (const char* key :
       {"input.rotate", "objectives.support_free", "objectives.strength",
        "objectives.surface_quality", "deform.max_tilt", "nozzle.diameter", "layers.min_thickness",
        "layers.max_thickness", "toolpath.width", "toolpath.spacing", "machine"})
    CHECK_NOTHROW(leaf(key));
}

TEST_CASE("every default lies in its range, every key is there once, every text is a sentence") {
  s3::Params params;
  const auto list = s3::list_params(params);
  CHECK_NOTHROW(s3::check_ranges(list));
  for (const s3::ParamRef& param : list.params()) {
    CHECK(list.find(param.info.key) == &param);
    CHECK(!param.info.label.empty());
    CHECK_MESSAGE(param.info.doc.ends_with("."), param.info.key);
  }
}

TEST_CASE("what is left open follows from the nozzle and the machine") {
  const auto machine = s3::bundled_machine(s3::MachineParams{}.machine);
  s3::Params params;
  params.layers.nozzle_diameter = 0.8;
  auto resolved = s3::resolve(params, machine);
  CHECK(resolved.layers.min_thickness == doctest::Approx(0.32));
  CHECK(resolved.layers.max_thickness == doctest::Approx(0.8));
  CHECK(resolved.toolpath.width == doctest::Approx(0.8));
  CHECK(resolved.deform.max_tilt_deg == doctest::Approx(s3::degrees(machine.max_tilt)));
  params.deform.max_tilt_deg = 33;
  params.layers.min_thickness = 0.2;
  resolved = s3::resolve(params, machine);
  CHECK(resolved.deform.max_tilt_deg == 33);
  CHECK(resolved.layers.min_thickness == 0.2);
  // Resolved parameters stay as they are.
  s3::Params again = s3::resolve(resolved, machine);
  CHECK(s3::diff(s3::list_params(resolved), s3::list_params(again)).empty());
}

TEST_CASE("parameters that contradict each other are errors") {
  const auto machine = s3::bundled_machine(s3::MachineParams{}.machine);
  s3::Params thin;
  thin.layers.min_thickness = 1;
  thin.layers.max_thickness = 0.5;
  CHECK_THROWS_AS(s3::resolve(thin, machine), s3::Error);
  s3::Params nothing;
  nothing.objectives.support_free = 0;
  CHECK_THROWS_AS(s3::resolve(nothing, machine), s3::Error);
}
