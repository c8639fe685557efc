#include "mesh/read_3mf.h"

#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "damaged_files.h"
#include "stored_zip.h"

using namespace s3;

namespace {

using test::stored_zip;

std::string relation(const std::string& target) {
  return "<?xml version=\"1.0\"?><Relationships><Relationship Target=\"" + target +
         "\" Id=\"rel0\" "
         "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
}

const std::string kCore =
    "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
    "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\"";

std::string model_xml(const std::string& inside, const std::string& attributes = "") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model " + attributes + " " + kCore + ">\n" +
         inside + "</model>\n";
}

std::string archive_of(const std::string& xml) {
  return stored_zip({{"[Content_Types].xml", "<Types/>"},
                     {"_rels/.rels", relation("/3D/3dmodel.model")},
                     {"3D/3dmodel.model", xml}});
}

// The tetrahedron (0,0,0) (1,0,0) (0,2,0) (0,0,3), outward, volume 1.
const std::string kMesh =
    "<mesh><vertices>\n<vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>"
    "<vertex x=\"0\" y=\"2\" z=\"0\"></vertex><vertex z=\"3\" y='0' x=\"0\" />\n</vertices>"
    "<triangles>\n<triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/>"
    "<triangle v1=\"0\" v2=\"3\" v3=\"2\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\" pid=\"1\"/>\n"
    "</triangles></mesh>";

std::string object(int id, const std::string& inside, const std::string& attributes = "") {
  return "<object id=\"" + std::to_string(id) + "\" " + attributes + ">" + inside + "</object>\n";
}

std::string item(int id, const std::string& attributes = "") {
  return "<item objectid=\"" + std::to_string(id) + "\" " + attributes + "/>\n";
}

std::string component(int id, const std::string& attributes = "") {
  return "<component objectid=\"" + std::to_string(id) + "\" " + attributes + "/>";
}

std::string components(const std::string& inside) {
  return "<components>" + inside + "</components>";
}

std::string resources(const std::string& inside) {
  return "<metadata name=\"Title\">x &lt; y</metadata>\n<resources>\n" + inside + "</resources>\n";
}

std::string build(const std::string& items) {
  return "<build>\n" + items + "</build>\n";
}

ModelFile read_xml(const std::string& xml) {
  return test::read(archive_of(xml), "a.3mf");
}

std::string error_of(const std::string& bytes) {
  try {
    test::read(bytes, "a.3mf");
  } catch (const Error& e) {
    CHECK(e.kind == ErrorKind::input);
    CHECK(!e.hint.empty());
    return e.code + " | " + e.what();
  }
  return "no error";
}

std::string error_of_xml(const std::string& xml) {
  return error_of(archive_of(xml));
}

TriMesh part_of(const ModelFile& model, Index part) {
  TriMesh mesh;
  mesh.vertices = model.surface.vertices;
  Eigen::Index rows = 0;
  mesh.triangles.resize(model.surface.triangles.rows(), 3);
  for (Eigen::Index f = 0; f < model.surface.triangles.rows(); ++f)
    if (model.part_of_triangle[static_cast<std::size_t>(f)] == part)
      mesh.triangles.row(rows++) = model.surface.triangles.row(f);
  mesh.triangles.conservativeResize(rows, 3);
  return mesh;
}

const std::string kOne = resources(object(1, kMesh, "name=\"a &amp; b\"")) + build(item(1));

}  // namespace

TEST_CASE("a 3MF file of one object is one part in mm") {
  const ModelFile model = read_xml(model_xml(kOne, "unit=\"millimeter\""));
  CHECK(model.format == "3mf");
  CHECK(!model.is_volume);
  CHECK(model.warnings.empty());
  CHECK(model.part_names == std::vector<std::string>{"a & b"});
  CHECK(model.part_of_triangle == std::vector<Index>{0, 0, 0, 0});
  CHECK(model.surface.vertices.rows() == 4);
  CHECK(enclosed_volume(model.surface) == doctest::Approx(1));
  CHECK(read_xml(model_xml(kOne)).warnings.empty());  // mm where there is no unit
}

TEST_CASE("the units of a 3MF file are converted, and that is said") {
  const std::pair<const char*, double> units[] = {
      {"micron", 0.001}, {"centimeter", 10}, {"inch", 25.4}, {"foot", 304.8}, {"meter", 1000}};
  for (const auto& entry : units) {
    const std::string unit = entry.first;
    const double mm = entry.second;
    CAPTURE(unit);
    const std::string moved =
        resources(object(1, kMesh)) + build(item(1, "transform=\"1 0 0 0 1 0 0 0 1 10 20 30\""));
    const ModelFile model = read_xml(model_xml(moved, "unit=\"" + std::string(unit) + "\""));
    CHECK(enclosed_volume(model.surface) == doctest::Approx(mm * mm * mm));
    CHECK(model.surface.vertices(0, 2) == doctest::Approx(30 * mm));
    REQUIRE(model.warnings.size() == 1);
    CHECK(model.warnings[0].code == "mesh.units");
    CHECK(model.warnings[0].message.find(unit) != std::string::npos);
    CHECK(model.warnings[0].message.find("input.scale") != std::string::npos);
  }
  CHECK(read_xml(model_xml(kOne, "unit=\"micron\"")).warnings[0].message.find("times 0.001.") !=
        std::string::npos);
  CHECK(read_xml(model_xml(kOne, "unit=\"meter\"")).warnings[0].message.find("times 1000.") !=
        std::string::npos);
  CHECK(error_of_xml(model_xml(kOne, "unit=\"parsec\"")).find("'parsec' is no unit") !=
        std::string::npos);
}

TEST_CASE("build items and components are placed by their transforms and stay parts") {
  // Object 3 holds 1 turned by 90° about z and moved, and 2, which holds 1 at twice the size.
  const std::string xml = model_xml(
      resources(
          object(1, kMesh, "name=\"tet\"") +
          object(2, components(component(1, "transform=\"2 0 0 0 2 0 0 0 2 0 0 0\""))) +
          object(3,
                 components(component(1, "transform=\"0 1 0 -1 0 0 0 0 1 5 0 0\"") + component(2)),
                 "name=\"pair\"")) +
      build(item(3, "transform=\"1 0 0 0 1 0 0 0 1 0 0 100\"") + item(1) +
            item(1, "transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"")));
  const ModelFile model = read_xml(xml);
  CHECK(model.part_names == std::vector<std::string>{"tet", "tet", "tet", "tet"});
  REQUIRE(model.surface.triangles.rows() == 16);
  // Row vectors: (x, y, z) → (5 − y, x, z + 100).
  CHECK(model.surface.vertices.row(1).isApprox(Points::RowXpr::PlainObject(5, 1, 100)));
  CHECK(model.surface.vertices.row(2).isApprox(Points::RowXpr::PlainObject(3, 0, 100)));
  CHECK(model.surface.vertices.row(7).isApprox(Points::RowXpr::PlainObject(0, 0, 106)));
  CHECK(enclosed_volume(part_of(model, 0)) == doctest::Approx(1));
  CHECK(enclosed_volume(part_of(model, 1)) == doctest::Approx(8));
  CHECK(enclosed_volume(part_of(model, 2)) == doctest::Approx(1));
  // A mirrored part is still outward.
  CHECK(model.surface.vertices.row(13).isApprox(Points::RowXpr::PlainObject(-1, 0, 0)));
  CHECK(enclosed_volume(part_of(model, 3)) == doctest::Approx(1));
}

TEST_CASE("meshes in other files of a 3MF archive are found") {
  const std::string there = "p:path=\"/3D/Objects/one.model\" ";
  const std::string root =
      model_xml(resources(object(
                    2, components(component(1, there + "transform=\"1 0 0 0 1 0 0 0 1 7 0 0\"")))) +
                    build(item(2) + item(1, there)),
                "requiredextensions=\"p\"");
  const std::string other =
      model_xml(resources(object(1, kMesh, "name=\"far\"")) + "<build/>\n", "unit=\"inch\"");
  const ModelFile model = test::read(stored_zip({{"_rels/.rels", relation("/3D/root.model")},
                                                 {"3D/root.model", root},
                                                 {"3D/Objects/one.model", other}}),
                                     "a.3mf");
  CHECK(model.part_names == std::vector<std::string>{"far", "far"});
  CHECK(model.surface.vertices(1, 0) == doctest::Approx(7 + 25.4));
  CHECK(model.surface.vertices(5, 0) == doctest::Approx(25.4));
  REQUIRE(model.warnings.size() == 1);
  CHECK(model.warnings[0].code == "mesh.units");
}

TEST_CASE("the core of a 3MF file may have a prefix, and what others add is passed over") {
  std::string xml = model_xml(kOne);
  for (const char* name : {"model", "resources", "object", "mesh", "vertices", "vertex",
                           "triangles", "triangle", "build", "item"})
    for (const std::string& open : {std::string("<"), std::string("</")})
      for (const char* end : {" ", ">"}) {
        const std::string from = open + name + end, to = open + "c:" + name + end;
        for (std::size_t at = 0; (at = xml.find(from, at)) != std::string::npos; at += to.size())
          xml.replace(at, from.size(), to);
      }
  CHECK(read_xml(test::replaced(xml, "xmlns=", "xmlns:c=")).surface.triangles.rows() == 4);

  const std::string beams = test::replaced(
      kOne, "</mesh>", "<b:beamlattice><b:beams><b:vertex/></b:beams></b:beamlattice></mesh>");
  const ModelFile model =
      read_xml(model_xml(beams, "requiredextensions=\"b\" xmlns:b=\"urn:beams\""));
  CHECK(model.surface.triangles.rows() == 4);
  REQUIRE(model.warnings.size() == 1);
  CHECK(model.warnings[0].code == "mesh.3mf_extension");
  CHECK(model.warnings[0].message.find("urn:beams") != std::string::npos);
}

TEST_CASE("a 3MF file says when supports are left out or nothing is to be built") {
  const std::string objects = resources(object(1, kMesh) + object(2, kMesh, "type=\"support\""));
  const ModelFile supported = read_xml(model_xml(objects + build(item(1) + item(2))));
  CHECK(supported.part_names.size() == 1);
  REQUIRE(supported.warnings.size() == 1);
  CHECK(supported.warnings[0].code == "mesh.3mf_supports");

  const std::string library =
      resources(object(1, kMesh) + object(2, components(component(1))) + object(3, kMesh));
  const ModelFile all = read_xml(model_xml(library + "<build/>\n"));
  CHECK(all.part_names.size() == 2);
  REQUIRE(all.warnings.size() == 1);
  CHECK(all.warnings[0].code == "mesh.3mf_no_build");
}

TEST_CASE("3MF errors say where and what") {
  CHECK(error_of_xml(model_xml(kOne)) == "no error");
  const auto xml = [](const std::string& from, const std::string& to) {
    return error_of_xml(model_xml(test::replaced(kOne, from, to)));
  };
  CHECK(xml("v2=\"2\"", "v2=\"9\"")
            .find("a.3mf (3D/3dmodel.model): line 9: a triangle names "
                  "vertex 9, the object has 4") != std::string::npos);
  CHECK(xml("v2=\"2\"", "v2=\"-1\"").find("line 8: a triangle with v2 = '-1'") !=
        std::string::npos);
  CHECK(xml("x=\"1\"", "x=\"nan\"").find("a vertex with x = 'nan'") != std::string::npos);
  CHECK(
      xml("objectid=\"1\"", "objectid=\"4294967296\"").find("object 4294967296 is named before") !=
      std::string::npos);
  CHECK(xml("</mesh>", "</mash>").find("</mash> closes what was not opened") != std::string::npos);
  CHECK(xml("objectid=\"1\"", "objectid=\"1\" transform=\"1 0 0 0 1 0 0 0\"")
            .find("a transform with ''") != std::string::npos);
  CHECK(xml("objectid=\"1\"", "objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 0 0 0 0\"")
            .find("leaves no volume") != std::string::npos);
  CHECK(error_of_xml(model_xml(resources(object(1, components(component(1)))) + build(item(1))))
            .find("object 1 is named before it is there") != std::string::npos);
  CHECK(error_of_xml(model_xml(resources("") + build(""))).find("mesh.empty_file") == 0);
  CHECK(error_of(stored_zip({{"a.txt", "x"}})).find("holds no '3D/3dmodel.model'") !=
        std::string::npos);
}

TEST_CASE("a small 3MF file cannot ask for much time or memory") {
  std::string objects = object(1, kMesh);
  for (int id = 2; id < 30; ++id) {
    std::string inside;
    for (int i = 0; i < 10; ++i) inside += component(id - 1);
    objects += object(id, components(inside));
  }
  CHECK(error_of_xml(model_xml(resources(objects) + build(item(29)))).find("too often") !=
        std::string::npos);

  objects = object(1, kMesh);
  for (int id = 2; id < 100; ++id) objects += object(id, components(component(id - 1)));
  CHECK(error_of_xml(model_xml(resources(objects) + build(item(99))))
            .find("components within components too often") != std::string::npos);

  std::string bomb = archive_of(model_xml(kOne));
  const std::size_t entry = bomb.rfind("PK\x01\x02");
  bomb.replace(entry + 24, 4, "\xff\xff\xff\xff");
  CHECK(error_of(bomb).find("claims to unpack from") != std::string::npos);
}

TEST_CASE("a 3MF file cut or damaged anywhere gives an error or a mesh in range") {
  const std::string xml =
      model_xml(resources(object(1, kMesh) + object(2, components(component(1)))) +
                build(item(2, "transform=\"1 0 0 0 1 0 0 0 1 7 0 0\"")));
  test::check_damage(archive_of(xml), "a.3mf");
  // Behind the check sum of the archive, too.
  for (std::size_t size = 0; size < xml.size(); ++size)
    test::check_read(archive_of(xml.substr(0, size)), "a.3mf");
  for (std::size_t bit = 0; bit < 8 * xml.size(); ++bit) {
    std::string damaged = xml;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    test::check_read(archive_of(damaged), "a.3mf");
  }
}

TEST_CASE("a file packed by gzip is read as what is in it") {
  // printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' | gzip
  const unsigned char bytes[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03,
                                 0x2b, 0x53, 0x30, 0x00, 0x41, 0xae, 0x32, 0x05, 0x43, 0x28,
                                 0x6d, 0x00, 0x62, 0x71, 0xa5, 0x01, 0x49, 0x23, 0x05, 0x63,
                                 0x2e, 0x00, 0x43, 0xf9, 0x6e, 0x2a, 0x20, 0x00, 0x00, 0x00};
  const std::string good(reinterpret_cast<const char*>(bytes), sizeof bytes);
  const ModelFile model = test::read(good, "a.obj.gz");
  CHECK(model.format == "obj");
  CHECK(surface_area(model.surface) == doctest::Approx(0.5));
  test::check_damage(good, "a.obj.gz");
  std::string bomb = good;
  bomb.replace(bomb.size() - 4, 4, "\xff\xff\xff\x7f");
  CHECK(error_of(bomb).find("claims to unpack from") != std::string::npos);
  std::string damaged = good;
  damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1);
  CHECK(error_of(damaged).find("the gzip file is damaged") != std::string::npos);
}
