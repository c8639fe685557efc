#include <doctest/doctest.h>

#include <string>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/units.h"
#include "motion/machine_profile.h"
#include "motion/machine_profile_json.h"

using namespace s3;

TEST_CASE("bundled machines are complete") {
  REQUIRE(bundled_machines().size() >= 3);
  CHECK(bundled_machine(MachineParams{}.machine).kinematics == Kinematics::table_bc);
  for (const std::string& name : bundled_machines()) {
    CAPTURE(name);
    const MachineProfile m = bundled_machine(name);
    CHECK(m.name == name);
    CHECK(m.max_tilt > 0);
    CHECK(m.max_tilt <= radians(90));
    CHECK(m.head_cone_angle == doctest::Approx(radians(90)));
    CHECK(m.print_speed > 0);
    CHECK(m.travel_speed > 0);
    CHECK(m.max_flow > 0);
    CHECK(m.x.max > m.x.min);
    CHECK(m.programs.size() == 1);
    // The machine can turn as far as it promises.
    if (m.kinematics == Kinematics::table_bc) CHECK(m.b.max >= m.max_tilt);
    if (m.kinematics == Kinematics::head_ab) CHECK(m.a.max >= m.max_tilt);
  }
  CHECK_THROWS_WITH_AS(bundled_machine("drill"), doctest::Contains("table-bc-duet"), Error);
}

TEST_CASE("a profile file changes what it names and inherits the rest") {
  const MachineProfile m = parse_machine_profile(
      R"({"inherits": "table-bc-duet", "name": "mine", "max_tilt_deg": 55, "pivot": [1, 2, -3],
          "b": {"min": -5, "max": 60}, "max_flow": 22.5, "start_gcode": ["G28", "M98 P\"home.g\""]})",
      "mine.json");
  const MachineProfile base = bundled_machine("table-bc-duet");
  CHECK(m.name == "mine");
  CHECK(m.max_tilt == doctest::Approx(radians(55)));
  CHECK(m.pivot == Vec3(1, 2, -3));
  CHECK(m.b.min == doctest::Approx(radians(-5)));
  CHECK(m.b.max == doctest::Approx(radians(60)));
  CHECK(m.b.speed == base.b.speed);
  CHECK(m.max_flow == 22.5);
  CHECK(m.start_gcode.size() == 2);
  CHECK(m.print_speed == base.print_speed);
}

TEST_CASE("a wrong profile is refused with key, value and range") {
  struct Case {
    const char *json, *names;
  };
  const Case cases[] = {{"{", "JSON"},
                        {"[]", "object"},
                        {"{}", "inherits"},
                        {R"({"inherits": "drill"})", "drill"},
                        {R"({"inherits": "head-ab", "max_tild_deg": 3})", "max_tild_deg"},
                        {R"({"inherits": "head-ab", "max_tilt_deg": 300})", "300"},
                        {R"({"inherits": "head-ab", "max_tilt_deg": "30"})", "number"},
                        {R"({"inherits": "head-ab", "pivot": [1, 2]})", "pivot"},
                        {R"({"inherits": "head-ab", "x": {"min": 5, "max": 1}})", "x"},
                        {R"({"inherits": "head-ab", "x": {"low": 5}})", "x.low"},
                        {R"({"inherits": "head-ab", "kinematics": "delta"})", "delta"},
                        {R"({"inherits": "head-ab", "start_gcode": [1]})", "start_gcode"}};
  for (const Case& c : cases) {
    CAPTURE(c.json);
    CHECK_THROWS_WITH_AS(parse_machine_profile(c.json, "file.json"), doctest::Contains(c.names),
                         Error);
  }
}

TEST_CASE("a profile written as JSON reads back as the same machine") {
  for (const std::string& name : bundled_machines()) {
    CAPTURE(name);
    const MachineProfile m = bundled_machine(name);
    const std::string text = to_json(m).dump();
    const MachineProfile back = parse_machine_profile(text, "profile.json");
    CHECK(back.name == m.name);
    CHECK(back.description == m.description);
    CHECK(back.kinematics == m.kinematics);
    CHECK(back.max_tilt == doctest::Approx(m.max_tilt).epsilon(1e-12));
    CHECK(back.head_cone_angle == doctest::Approx(m.head_cone_angle).epsilon(1e-12));
    CHECK(back.pivot == m.pivot);
    for (const auto axis : {&MachineProfile::x, &MachineProfile::z, &MachineProfile::a,
                            &MachineProfile::b, &MachineProfile::c}) {
      CHECK((back.*axis).min == doctest::Approx((m.*axis).min).epsilon(1e-12));
      CHECK((back.*axis).max == doctest::Approx((m.*axis).max).epsilon(1e-12));
      CHECK((back.*axis).speed == doctest::Approx((m.*axis).speed).epsilon(1e-12));
    }
    CHECK(back.filament_density == m.filament_density);
    CHECK(back.programs == m.programs);
    CHECK(back.start_gcode == m.start_gcode);
    CHECK(back.end_gcode == m.end_gcode);
  }
}
