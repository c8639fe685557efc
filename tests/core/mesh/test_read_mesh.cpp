#include "mesh/read_mesh.h"

#include <doctest/doctest.h>

#include <cstring>
#include <string>
#include <vector>

#include "base/error.h"
#include "damaged_files.h"
#include "mesh/text_scanner.h"

using namespace s3;

namespace {

using test::read;

std::string error_of(const std::string& text, std::string_view name) {
  try {
    read(text, name);
  } catch (const Error& e) {
    CHECK(e.kind == ErrorKind::input);
    CHECK(!e.hint.empty());
    return e.code + " | " + e.what();
  }
  return "no error";
}

// The tetrahedron (0,0,0) (1,0,0) (0,1,0) (0,0,1), outward.
const std::vector<std::vector<Vec3>> kTriangles = {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}},
                                                   {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                                                   {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                                   {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

std::string binary_stl(const std::string& header = "made by a test") {
  std::string file = header;
  file.resize(80, ' ');
  const auto put = [&](auto value) {
    file.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(static_cast<std::uint32_t>(kTriangles.size()));
  for (const auto& triangle : kTriangles) {
    for (int i = 0; i < 3; ++i) put(0.0f);
    for (const Vec3& p : triangle)
      for (int i = 0; i < 3; ++i) put(static_cast<float>(p[i]));
    put(std::uint16_t{0});
  }
  return file;
}

std::string ascii_stl() {
  std::string file = "solid tetrahedron\n";
  for (const auto& triangle : kTriangles) {
    file += " facet normal 0 0 0\n  outer loop\n";
    for (const Vec3& p : triangle)
      file += "   vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " +
              std::to_string(p.z()) + "\r\n";
    file += "  endloop\n endfacet\n";
  }
  return file + "endsolid tetrahedron\n";
}

const std::string kObj =
    "# comment\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvt 0 0\n"
    "f 1/1/1 3/1/1 2/1/1\nf 1//1 2//1 4//1\nf 1/1 4/1 3/1\nf -3 -2 -1\n";
const std::string kOff =
    "OFF # keyword\n# counts\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n\n0 0 1\n"
    "3 0 2 1\n3 0 1 3 255 0 0\n3 0 3 2\n3 1 2 3\n";
const std::string kTet = "4 vertices\n1 tets\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n4 0 1 2 3\n";

}  // namespace

TEST_CASE("every surface format reads the same tetrahedron") {
  const std::pair<std::string, std::string> files[] = {
      {binary_stl(), "stl-binary"}, {ascii_stl(), "stl-ascii"}, {kObj, "obj"}, {kOff, "off"}};
  for (const auto& file : files) {
    const std::string& format = file.second;
    CAPTURE(format);
    const ModelFile model = read(file.first, "part");  // no extension: the content decides
    CHECK(model.format == format);
    CHECK(!model.is_volume);
    REQUIRE(model.surface.vertices.rows() == 4);
    REQUIRE(model.surface.triangles.rows() == 4);
    CHECK(enclosed_volume(model.surface) == doctest::Approx(1.0 / 6));
    CHECK(surface_area(model.surface) == doctest::Approx(1.5 + std::sqrt(3.0) / 2));
  }
}

TEST_CASE("a binary STL that begins with the word solid is read as binary") {
  CHECK(read(binary_stl("solid made by a CAD program"), "a.stl").format == "stl-binary");
}

TEST_CASE("the content wins over a wrong extension") {
  CHECK(read(kOff, "a.stl").format == "off");
  CHECK(read(binary_stl(), "a.obj").format == "stl-binary");
}

TEST_CASE("a tet file keeps its order and its numbers") {
  const ModelFile model = read(kTet, "a.tet");
  CHECK(model.is_volume);
  CHECK(model.format == "tet");
  CHECK(model.vertices(3, 2) == 1);
  CHECK(model.tets.row(0) == Tets::RowXpr::PlainObject(0, 1, 2, 3));
}

TEST_CASE("polygons become fans") {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  CHECK(surface_area(read(square, "a.obj").surface) == doctest::Approx(1));
  const std::string pentagon =
      "COFF\n5 1 0\n0 0 0 9\n2 0 0 9\n2 1 0 9\n1 2 0 9\n0 1 0 9\n5 0 1 2 3 4\n";
  CHECK(surface_area(read(pentagon, "a.off").surface) == doctest::Approx(3));
}

TEST_CASE("negative zero and zero are one STL corner") {
  std::string file = ascii_stl();
  for (std::size_t at = file.find(" 0.000000 "); at != std::string::npos;
       at = file.find(" 0.000000 ", at + 200))
    file.replace(at, 10, " -0.00000 ");
  REQUIRE(file.find("-0") != std::string::npos);
  CHECK(read(file, "a.stl").surface.vertices.rows() == 4);
}

TEST_CASE("errors name the file, the line and the trouble") {
  CHECK(error_of("OFF BINARY\nxx", "a.off").find("binary OFF") != std::string::npos);
  CHECK(error_of("v 0 0 0\nv 1 x 0\n", "a.obj")
            .find("a.obj: line 2: expected a coordinate, found 'x'") != std::string::npos);
  CHECK(error_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "a.obj").find("vertex 4") !=
        std::string::npos);
  CHECK(error_of("v 0 0 nan\nf 1 1 1\n", "a.obj").find("line 1") != std::string::npos);
  CHECK(error_of("v 0 0 1e999\nf 1 1 1\n", "a.obj").find("line 1") != std::string::npos);
  CHECK(error_of("v 0 0 0\nf 1 -2 1\n", "a.obj").find("vertex -2 does not exist") !=
        std::string::npos);
  CHECK(error_of("4294967295 vertices\n4294967295 tets\n0 0 0\n", "a.tet").find("too short") !=
        std::string::npos);
  CHECK(error_of("OFF\n4000000000 4000000000 0\n", "a.off").find("too short") != std::string::npos);
  CHECK(error_of("OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "a.off").find("vertex 1 of 1") !=
        std::string::npos);
  CHECK(error_of("PK\x03\x04", "a.3mf").find("no directory") != std::string::npos);
  CHECK(error_of("hello", "a.txt").find("mesh.unknown_format") == 0);
  CHECK(error_of("", "a.stl").find("mesh.bad_file") == 0);
  CHECK(error_of("", "a").find("mesh.unknown_format") == 0);
  CHECK(error_of("v 0 0 0\n", "a.obj").find("mesh.empty_file") == 0);
  std::string huge = binary_stl();
  huge.replace(80, 4, "\xff\xff\xff\xff");
  CHECK(error_of(huge, "a.stl").find("promises 4294967295 triangles, the file holds 4") !=
        std::string::npos);
}

TEST_CASE("a file cut or damaged anywhere gives an error or a mesh in range") {
  for (const char* name : {"a.stl", "a.obj", "a.off", "a.tet"})
    for (const std::string& file : {binary_stl(), ascii_stl(), kObj, kOff, kTet})
      test::check_damage(file, name);
}

TEST_CASE("objects of an OBJ file are parts, groups of one solid are not") {
  // Two tetrahedra; the first one's faces lie in two groups, one of which has points of its own.
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
      "v 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\n"
      "o  first  part \ng side\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"
      "o second\nf 8 10 9\nf 8 9 11\nf 8 11 10\nf 9 10 11\n"
      "o first  part \ng top\nf 5 6 7\n";
  const ModelFile model = read(text, "a.obj");
  CHECK(model.surface.triangles.rows() == 8);
  CHECK(model.part_names == std::vector<std::string>{"first  part", "second"});
  CHECK(model.part_of_triangle == std::vector<Index>{0, 0, 0, 1, 1, 1, 1, 0});
}

TEST_CASE("solids of a text STL are parts unless they touch") {
  const auto moved = [](std::string solid, const std::string& name, double x) {
    const std::string from = "vertex ";
    for (std::size_t at = solid.find(from); at != std::string::npos;
         at = solid.find(from, at + 1)) {
      const std::size_t begin = at + from.size(), end = solid.find(' ', begin);
      const double value = std::stod(solid.substr(begin, end - begin)) + x;
      solid.replace(begin, end - begin, std::to_string(value));
    }
    return test::replaced(solid, "solid tetrahedron", "solid " + name);
  };
  const std::string first = moved(ascii_stl(), "a b", 0);
  const ModelFile apart = read(first + moved(ascii_stl(), "c", 3), "a.stl");
  CHECK(apart.part_names == std::vector<std::string>{"a b", "c"});
  CHECK(apart.part_of_triangle == std::vector<Index>{0, 0, 0, 0, 1, 1, 1, 1});
  const ModelFile touching = read(first + moved(ascii_stl(), "c", 1), "a.stl");
  CHECK(touching.part_names == std::vector<std::string>{"a b"});
  CHECK(touching.part_of_triangle == std::vector<Index>(8, 0));
}

TEST_CASE("numbers are read as the C library reads them") {
  for (const char* text :
       {"0", "-0", "1", "-1.5", "+2.25", "3.14159265358979323846", "1e-5", "1E+22",
        "123456789012345678901234567890", "0.000000000000000000000000000123", "4.9e-324",
        "2.2250738585072011e-308", "1.7976931348623157e308", "9007199254740993", ".5", "5.",
        "-66.123456789e-3"}) {
    CAPTURE(text);
    REQUIRE(parse_double(text));
    CHECK(*parse_double(text) == std::strtod(text, nullptr));
  }
  for (const char* text :
       {"", ".", "-", "e5", "1e", "1e+", "0x10", "inf", "nan", "1.2.3", "1,5", "1e999", "--1"}) {
    CAPTURE(text);
    CHECK(!parse_double(text));
  }
  CHECK(*parse_integer("-42") == -42);
  CHECK(!parse_integer("1.0"));
  CHECK(!parse_integer("99999999999999999999"));
}
