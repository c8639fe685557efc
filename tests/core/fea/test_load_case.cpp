#include "fea/load_case.h"

#include <cmath>
#include <span>
#include <string>

#include <doctest/doctest.h>

#include "base/error.h"
#include "base/units.h"
#include "fea/loading.h"
#include "fea/rigid_motion.h"
#include "fea/stress.h"
#include "grid_mesh.h"

using namespace s3;

namespace {

LoadCases read(const std::string& text) {
  return read_load_cases(std::as_bytes(std::span(text.data(), text.size())), "load.json");
}

std::vector<Loading> apply(const std::string& text) {
  Context ctx;
  return apply_load_cases(test::make_grid(4, 4, 4, {4, 4, 4}), read(text), ctx);
}

/// "code: message" of the error, empty when there is none
std::string fault(const std::string& text) {
  try {
    apply(text);
  } catch (const Error& error) {
    CHECK(error.kind == ErrorKind::input);
    CHECK(error.stage == Stage::fea);
    CHECK_FALSE(error.hint.empty());
    return error.code + ": " + error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  const bool found = text.find(part) != std::string::npos;
  if (!found) MESSAGE(text);
  return found;
}

const std::string kHeld = R"({"region": "plate", "fixed": true})";
const std::string kTop = R"({"plane": {"point": [0, 0, 4], "normal": [0, 0, 1]}})";

std::string with(const std::string& conditions) {
  return R"({"conditions": [)" + conditions + "]}";
}

/// One condition on a region beside the plate.
std::string on(const std::string& region, const std::string& action) {
  return with(kHeld + R"(, {"region": )" + region + ", " + action + "}");
}

Vec3 total(const Loading& loading) {
  return loading.force.colwise().sum().transpose();
}

}  // namespace

TEST_CASE("a whole file is read: material, regions, common and own conditions") {
  const LoadCases file = read(R"({
    "about": "two cases",
    "material": {"young": 2000, "poisson": 0.3, "density": 1.1},
    "regions": {"lid": {"half_space": {"point": [0, 0, 3.9], "normal": [0, 0, 2]}}},
    "conditions": [{"region": "plate", "fixed": "xyz"}],
    "cases": [
      {"name": "press", "conditions": [{"region": ["lid", {"sphere": {"center": [1, 2, 3], "radius": 2}}], "pressure": 0.5}]},
      {"conditions": [{"gravity": [0, 0, -9.81]}, {"region": "lid", "displacement": [null, 0.1, null]}]}
    ]})");
  CHECK(file.material.young == 2000);
  CHECK(file.material.printed.young[1] == doctest::Approx(2000 * 1.2 / 3.5));
  REQUIRE(file.cases.size() == 2);
  CHECK(file.cases[0].name == "press");
  CHECK(file.cases[1].name == "cases[1]");
  REQUIRE(file.cases[0].conditions.size() == 2);
  REQUIRE(file.cases[1].conditions.size() == 3);
  const Region& both = file.regions[file.cases[0].conditions[1].region];
  REQUIRE(both.shapes.size() == 2);
  CHECK(std::get<HalfSpace>(both.shapes[0]).normal == Vec3::UnitZ());
  CHECK(std::get<Pressure>(file.cases[0].conditions[1].action).megapascal == 0.5);
  const auto& moved = std::get<Displacement>(file.cases[1].conditions[2].action);
  CHECK_FALSE(moved.value[0].has_value());
  CHECK(moved.value[1] == 0.1);
}

TEST_CASE("every bundled material has a source and constants that can exist") {
  for (const Material& material : bundled_materials()) {
    CAPTURE(material.name);
    CHECK(material.source.size() > 40);
    CHECK(material.density > 0.8);
    CHECK_NOTHROW(isotropic_stiffness(material.young, material.poisson));
    CHECK_NOTHROW(orthotropic_stiffness(material.printed));
    CHECK(read(R"({"material": ")" + material.name + R"(", "conditions": [)" + kHeld + "]}")
              .material.name == material.name);
  }
  const Material& pla = read(with(kHeld)).material;  // where nothing is said
  CHECK(pla.name == "PLA");
  CHECK(pla.printed.young == Vec3(3500, 1200, 1200));
}

TEST_CASE("regions take the faces that they say") {
  const TetMesh mesh = test::make_grid(4, 4, 4, {4, 4, 4});
  const auto faces = [&](const Shape& shape) {
    return region_faces(mesh, Region{"r", {shape}}).size();
  };
  CHECK(faces(PlateContact{}) == 32);
  CHECK(faces(PlaneContact{{0, 0, 4}, Vec3::UnitZ(), {}}) == 32);
  CHECK(faces(PlaneContact{{0, 0, 3.95}, Vec3::UnitZ(), 0.1}) == 32);
  CHECK(faces(HalfSpace{{0, 0, 3}, Vec3::UnitZ()}) == 32 + 4 * 8);
  CHECK(faces(BoxRegion{{-1, -1, 3.9}, {2, 5, 5}}) == 16);
  CHECK(faces(SphereRegion{{0, 0, 0}, 0.8}) == 6);
  const auto one = std::make_shared<const std::vector<Vec3>>(1, Vec3(1.1, 1.2, 4.5));
  CHECK(faces(PickedFaces{one, 0}) == 1);
  CHECK(faces(PickedFaces{one, radians(30)}) == 32);
  CHECK(faces(PickedFaces{one, radians(95)}) == 32 + 4 * 32);  // the sides too, not the bottom
}

TEST_CASE("the tets of a region are those inside of it and those behind its faces") {
  const TetMesh mesh = test::make_grid(4, 4, 4, {4, 4, 4});
  const auto tets = [&](const std::vector<Shape>& shapes) {
    return region_tets(mesh, Region{"r", shapes});
  };
  const std::vector<Index> middle = tets({BoxRegion{{1, 1, 1}, {3, 3, 3}}});
  CHECK(middle.size() == 8 * 6);  // without a single face
  for (const Index t : middle) CHECK((mesh.centroid(t) - Vec3(2, 2, 2)).cwiseAbs().maxCoeff() < 1);
  CHECK(tets({HalfSpace{{0, 0, 2}, Vec3::UnitZ()}}).size() == 32 * 6);
  const std::vector<Index> lid = tets({PlaneContact{{0, 0, 4}, Vec3::UnitZ(), {}}});
  CHECK(lid.size() == 32);  // each face of the lid has a tet of its own
  for (const Index t : lid) CHECK(mesh.centroid(t).z() > 3);
  // A union counts each once.
  CHECK(tets({HalfSpace{{0, 0, 2}, Vec3::UnitZ()}, PlaneContact{{0, 0, 4}, Vec3::UnitZ(), {}}})
            .size() == 32 * 6);
  CHECK_THROWS_AS(tets({SphereRegion{{9, 9, 9}, 1}}), Error);
}

TEST_CASE("a region file names shapes, and its faults name the file and the stage") {
  const auto read_region = [](const std::string& text, Stage stage) {
    return read_region_file(std::as_bytes(std::span(text.data(), text.size())), "back.json", stage);
  };
  const Region region = read_region(
      R"({"about": "back", "regions": {"lid": {"box": {"min": [0, 0, 3], "max": [4, 4, 5]}}},
          "region": ["lid", "plate", {"sphere": {"center": [1, 2, 3], "radius": 2}}]})",
      Stage::objectives);
  REQUIRE(region.shapes.size() == 3);
  CHECK(std::get<SphereRegion>(region.shapes[2]).radius == 2);
  CHECK(region.name.find("back.json") != std::string::npos);
  const auto code = [&](const std::string& text, Stage stage) -> std::string {
    try {
      read_region(text, stage);
    } catch (const Error& error) {
      CHECK(error.stage == stage);
      CHECK(contains(error.what(), "back.json"));
      return error.code;
    }
    return "";
  };
  CHECK(code(R"({"region": {"ball": 1}})", Stage::objectives) == "objectives.bad_region");
  CHECK(code(R"({"region": []})", Stage::fea) == "fea.bad_region");
  CHECK(code(R"({"region": "lid"})", Stage::fea) == "fea.bad_region");
  CHECK(code(R"({"conditions": []})", Stage::fea) == "fea.bad_region");
  CHECK(code("{", Stage::fea) == "fea.bad_region");
}

TEST_CASE("tets that are added to S are there once, and only where there is a direction") {
  StressField stress;
  stress.principal = Directions::Zero(6, 3);
  for (const Index t : {0, 1, 2, 4}) stress.principal(t, 0) = 1;
  stress.critical_tets = {1, 4};
  add_critical_tets({0, 1, 3}, stress);
  CHECK(stress.critical_tets == std::vector<Index>{0, 1, 4});
}

TEST_CASE("forces, pressure and weight add up to what was asked for") {
  CHECK((total(apply(on(kTop, R"("force": [1, 2, -30])"))[0]) - Vec3(1, 2, -30)).norm() < 1e-12);
  CHECK((total(apply(on(kTop, R"("pressure": 0.5)"))[0]) - Vec3(0, 0, -8)).norm() < 1e-12);
  const Loading weight = apply(with(kHeld + R"(, {"gravity": [0, 0, -10]})"))[0];
  CHECK(total(weight).z() == doctest::Approx(-64 * 1.24e-6 * 10));  // PLA, 64 mm³
  const Loading pushed = apply(on(kTop, R"("displacement": [null, null, -0.2])"))[0];
  for (std::size_t v = 0; v < pushed.held.size(); ++v)
    if (pushed.held[v] == 4) CHECK(pushed.displacement(static_cast<Index>(v), 2) == -0.2);
}

TEST_CASE("a part that is not held is an error that names the free motions") {
  const auto free = [&](const std::string& axes, const std::string& region = R"("plate")") {
    return fault(with(R"({"region": )" + region + R"(, "fixed": ")" + axes +
                      R"("}, {"gravity": [0, 0, -1]})"));
  };
  CHECK(free("xyz").empty());
  CHECK(contains(free("z"), "fea.unconstrained"));
  CHECK(contains(free("z"), "it can still slide along x, slide along y and turn about z."));
  // The plate's plane held in itself lets the part tip about its axes.
  CHECK(contains(free("xy"), "it can still slide along z, turn about x and turn about y."));
  CHECK(contains(free("x"), "slide along y, slide along z, turn about x and turn about y."));
  CHECK(contains(fault(with(R"({"gravity": [0, 0, -1]})")), "move and turn in every way"));
  // The edge x = 0, z = 0 as a hinge.
  const TetMesh mesh = test::make_grid(4, 4, 4, {4, 4, 4});
  std::vector<std::uint8_t> held(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.vertices(v, 0) < 1e-9 && mesh.vertices(v, 2) < 1e-9) held[v] = 7;
  CHECK(free_motions(mesh, held) == std::vector<std::string>{"turn about y through (0, 2, 0)"});
}

TEST_CASE("pieces that share an edge only may hinge there, and bodies apart are held each") {
  Points vertices(10, 3);
  vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, 0, -1,  // two tets at the y axis
      5, 0, 0, 6, 0, 0, 5, 1, 0, 5, 0, 1;
  Tets tets(3, 4);
  tets << 0, 1, 2, 3, 0, 4, 2, 5, 6, 7, 8, 9;
  const TetMesh mesh = make_tet_mesh(vertices, tets);
  std::vector<std::uint8_t> held(10, 0);
  for (const int v : {0, 1, 2, 3, 6, 7, 8}) held[static_cast<std::size_t>(v)] = 7;
  const auto hinge = free_motions(mesh, held);
  REQUIRE(hinge.size() == 1);
  CHECK(contains(hinge[0], "move in the piece around (-0.25, 0.25, -0.25)"));
  held[5] = 7;
  CHECK(free_motions(mesh, held).empty());
  held[6] = held[7] = 0;
  CHECK(contains(free_motions(mesh, held).front() + free_motions(mesh, held).back(), "turn about"));
}

TEST_CASE("contradictions and idle loads are errors with the regions' names") {
  CHECK(contains(fault(with(kHeld + R"(, {"region": "plate", "displacement": [0, 0, 1]})")),
                 "fea.contradictory: The regions plate and plate share the vertex"));
  CHECK(contains(fault(on(R"("plate")", R"("force": [0, 0, 5])")),
                 "fea.contradictory: The load on the region plate acts on held vertices only"));
  CHECK(fault(with(R"({"region": "plate", "fixed": "z"}, {"region": )" + kTop +
                   R"(, "fixed": "xy"}, {"region": "plate", "force": [1, 0, 0]})"))
            .empty());
  CHECK(contains(fault(with(kHeld)), "fea.no_load: Nothing loads the part"));
  const std::string far = R"({"sphere": {"center": [2, 2, 9], "radius": 1}})";
  const std::string empty = fault(on(far, R"("force": [1, 0, 0])"));
  CHECK(contains(empty, "fea.empty_region: The region conditions[1].region contains no face"));
  CHECK(contains(empty, "from (0, 0, 0) to (4, 4, 4) mm; the nearest face is"));
}

TEST_CASE("faults of the file are errors with their place") {
  const auto bad = [](const std::string& text, const std::string& part) {
    CAPTURE(text);
    const std::string message = fault(text);
    CHECK(message.starts_with("fea.bad_load_case: load.json"));
    CHECK(contains(message, part));
  };
  bad("", "is no JSON");
  bad("[1]", "the file must be an object");
  bad("{}", "has no conditions");
  bad(R"({"condition": []})", "unknown key \"condition\"");
  bad(R"({"conditions": []})", "conditions must be a list of at least one");
  bad(with(R"({"region": "plate"})"), "conditions[0] must have a region and one of");
  bad(with(R"({"region": "plate", "fixed": false})"), "conditions[0].fixed must be true or name");
  bad(with(R"({"region": "plate", "fixed": "w"})"), "must name axes out of x, y and z");
  bad(with(R"({"region": "ears", "fixed": true})"), "names the region \"ears\"");
  bad(with(R"({"region": "plate", "force": [1, 2]})"), "force must be a list of three numbers");
  bad(with(R"({"region": "plate", "force": [1, 2, 1e12]})"), "force[2] is beyond");
  bad(with(R"({"region": "plate", "force": [1, 2, 1e999]})"), "is no JSON");
  bad(with(R"({"region": "plate", "force": [1, 2, NaN]})"), "is no JSON");
  bad(with(R"({"region": "plate", "displacement": [null, null, null]})"), "leaves every axis free");
  bad(on(R"({"sphere": {"center": [0, 0, 0], "radius": -1}})", R"("pressure": 1)"),
      "region.sphere.radius must be above 0");
  bad(on(R"({"sphere": {"center": [0, 0, 0], "radius": 1}, "box": {}})", R"("pressure": 1)"),
      "exactly one shape");
  bad(on(R"({"box": {"min": [0, 0, 2], "max": [1, 1, 1]}})", R"("pressure": 1)"), "min above max");
  bad(on(R"({"plane": {"point": [0, 0, 2], "normal": [0, 0, 0]}})", R"("pressure": 1)"),
      "plane.normal must not be 0");
  bad(R"({"material": "cheese", "conditions": [)" + kHeld + "]}",
      "bundled materials are PLA, PETG");
  bad(R"({"material": {"young": 1000, "poisson": 0.3}, "conditions": [{"gravity": [0, 0, -1]}]})",
      "no density");
  CHECK(contains(
      fault(R"({"material": {"young": 1000, "poisson": 0.5}, "conditions": [)" + kHeld + "]}"),
      "fea.bad_material: The material needs a Poisson's ratio"));
  CHECK(contains(
      fault(R"({"material": {"young": 1000, "poisson": 0.3, "printed": {"young": [1000, 100, 100],
              "poisson": [0.9, 0.9, 0.9], "shear": [10, 10, 10]}}, "conditions": [)" +
            kHeld + "]}"),
      "is not stable"));
}

TEST_CASE("the envelope keeps the case that pulls a tet most") {
  // A post pulled at the top in one case and bent in the other: the tension side changes hands.
  const TetMesh mesh = test::make_grid(4, 4, 12, {4, 4, 12});
  const std::string top = R"({"plane": {"point": [0, 0, 12], "normal": [0, 0, 1]}})";
  const auto one = [&](const std::string& force) {
    return R"({"region": )" + top + R"(, "force": )" + force + "}";
  };
  const auto solve = [&](const std::string& text) {
    Context ctx;
    return analyse_stress(mesh, read(text), ctx);
  };
  const StressField pulled = solve(with(kHeld + "," + one("[0, 0, 8]")));
  const StressField bent = solve(with(kHeld + "," + one("[2, 0, 0]")));
  const StressField both =
      solve(R"({"conditions": [)" + kHeld + R"(], "cases": [{"conditions": [)" + one("[0, 0, 8]") +
            R"(]}, {"conditions": [)" + one("[2, 0, 0]") + "]}]}");
  int from_bent = 0;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    const bool bends = bent.principal_value[t] > pulled.principal_value[t];
    const StressField& expected = bends ? bent : pulled;
    from_bent += bends ? 1 : 0;
    CHECK(both.principal_value[t] == doctest::Approx(expected.principal_value[t]).epsilon(1e-5));
    CHECK((both.stress.row(t) - expected.stress.row(t)).norm() < 1e-5);
  }
  CHECK(from_bent > mesh.tet_count() / 5);
  CHECK(from_bent < 4 * mesh.tet_count() / 5);
}

TEST_CASE("smoothing keeps a constant field and the mean of any") {
  const TetMesh mesh = test::make_grid(3, 3, 3, {3, 2, 1});
  Context ctx;
  Tensors stress = Tensors::Random(mesh.tet_count(), 6);
  StressField field = stress_field(stress, ctx);
  smooth_stress(mesh, 0, field, ctx);
  CHECK(field.stress == stress);
  smooth_stress(mesh, 2, field, ctx);
  const Values volume = tet_volumes(mesh);
  CHECK((volume.transpose() * (field.stress - stress)).norm() < 1e-12);
  CHECK((field.stress.rowwise() - field.stress.colwise().mean()).norm() <
        0.5 * (stress.rowwise() - stress.colwise().mean()).norm());
  stress = Tensors::Ones(mesh.tet_count(), 6);
  field = stress_field(stress, ctx);
  smooth_stress(mesh, 3, field, ctx);
  CHECK((field.stress - stress).norm() < 1e-12);
}
