#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <string>

#include <doctest/doctest.h>

#include "base/error.h"
#include "fea/read_stress.h"

using namespace s3;

namespace {

StressField read(const std::string& text, Index tets, double ratio = 1) {
  return read_stress(std::as_bytes(std::span(text.data(), text.size())), "s.csv", tets, ratio);
}

/// "code: message" of the error, empty when there is none
std::string fault(const std::string& text, Index tets) {
  try {
    read(text, tets);
  } catch (const Error& error) {
    CHECK(error.kind == ErrorKind::input);
    return error.code + ": " + error.what();
  }
  return "";
}

std::string shared_file(const std::string& name) {
  const char* shared = std::getenv("S3_SHARED");
  if (shared == nullptr) return "";
  std::ifstream file(std::string(shared) + "/models/paper/" + name, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("a tensor row gives the largest principal stress and its direction, rows in any order") {
  // Tet 1: pure shear of 3 in xy: ±3 along (1, ±1, 0). Tet 2: diagonal, the largest is zz.
  const StressField field = read(
      "index,maxPrincipal,S11,S22,S33,S12,S13,S23\n"
      "2,9,1,2,5,0,0,0\r\n"
      "1,0,0,0,0,3,0,0\n",
      2);
  CHECK(field.principal_value[0] == doctest::Approx(3));
  CHECK((field.principal.row(0).transpose() - Vec3(1, 1, 0).normalized()).norm() < 1e-12);
  CHECK(field.principal_value[1] == doctest::Approx(5));
  CHECK((field.principal.row(1).transpose() - Vec3::UnitZ()).norm() < 1e-12);
  CHECK(field.stress(0, 5) == 3);
  CHECK(field.stress(1, 2) == 5);
}

TEST_CASE("shear components stand where the field says: xx yy zz yz zx xy") {
  const StressField field = read("1,0,1,2,3,12,13,23\n", 1);
  const double expected[6] = {1, 2, 3, 23, 13, 12};
  for (int c = 0; c < 6; ++c) CHECK(field.stress(0, c) == expected[c]);
}

TEST_CASE("five columns are read with blanks or commas, with or without a header") {
  for (const std::string text : {"4 0 3 4 0\n-1 1 0 0 7\n", "4,0,3,4,0\n-1,1,0,0,7",
                                 "principal x y z line\n\n4\t0 3 4 0\n# comment\n-1 1 0 0 7\n"}) {
    const StressField field = read(text, 2);
    CHECK(field.principal_value[0] == 4);
    CHECK((field.principal.row(0).transpose() - Vec3(0, 0.6, 0.8)).norm() < 1e-15);
    CHECK(field.principal_value[1] == -1);
    CHECK(field.stress.rows() == 0);
    CHECK(field.critical_tets == std::vector<Index>{0});
  }
}

TEST_CASE("the critical tets are the given share of all tets, with tension only, ties by index") {
  Values value(10);
  value << 5, -1, 3, 3, 0, 8, 3, -7, 1, 2;
  CHECK(critical_tets(value, 0.3) == std::vector<Index>{0, 2, 5});
  CHECK(critical_tets(value, 0.4) == std::vector<Index>{0, 2, 3, 5});
  CHECK(critical_tets(value, 0.0).empty());
  CHECK(critical_tets(value, 1.0) == std::vector<Index>{0, 2, 3, 5, 6, 8, 9});
  CHECK(critical_tets(Values(0), 0.3).empty());
  CHECK(critical_tets(Values::Constant(10, -1.0), 0.3).empty());
}

TEST_CASE("turned stress is the stress of the turned part") {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  StressField field;
  field.stress.resize(1, 6);
  for (int c = 0; c < 6; ++c) field.stress(0, c) = normal(random);
  const PrincipalStresses before = principal_stresses(field.stress.row(0).transpose());
  field.principal = before.direction.col(2).transpose();
  const Mat3 R = Eigen::AngleAxisd(1.1, Vec3(1, -2, 3).normalized()).toRotationMatrix();
  rotate_stress(field, R);
  const PrincipalStresses after = principal_stresses(field.stress.row(0).transpose());
  CHECK((after.value - before.value).norm() < 1e-12);
  const Vec3 expected = R * before.direction.col(2);
  CHECK(std::abs(after.direction.col(2).dot(expected)) == doctest::Approx(1));
  CHECK((field.principal.row(0).transpose() - expected).norm() < 1e-12);

  // A quarter turn about x, from y up to z up: (x, y, z) → (x, −z, y). Pull along y becomes pull
  // along z.
  field.stress.row(0) << 0, 7, 0, 0, 0, 0;
  Mat3 quarter;
  quarter << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  rotate_stress(field, quarter);
  CHECK(field.stress(0, 2) == doctest::Approx(7));
}

TEST_CASE("stress files that do not fit the mesh or are damaged name the line") {
  const std::string row = "1 1 0 0 0\n";
  CHECK(fault(row + row, 3) ==
        "fea.stress_count: s.csv has stress for 2 tets, but the mesh has 3 (the last row is line "
        "2).");
  CHECK(fault(row + row + "\n" + row + row, 2) ==
        "fea.stress_count: s.csv has stress for 4 tets, but the mesh has 2 (the first row too many "
        "is line 4).");
  CHECK(fault("", 2).starts_with("fea.stress_count"));
  CHECK(fault(row + "1 1 zero 0 0\n", 2) ==
        "fea.bad_stress_file: s.csv: line 2: 'zero' is not a number.");
  CHECK(fault(row + "1 1 nan 0 0\n", 2).starts_with("fea.bad_stress_file: s.csv: line 2"));
  CHECK(fault(row + "1 1 1e999 0 0\n", 2).starts_with("fea.bad_stress_file: s.csv: line 2"));
  CHECK(fault(row + "1 1 0 0\n", 2) == "fea.bad_stress_file: s.csv: line 2: 4 columns.");
  CHECK(fault("1 2 3\n", 1).starts_with("fea.bad_stress_file: s.csv: line 1"));
  CHECK(fault("head\nfoot\n", 1).starts_with("fea.bad_stress_file: s.csv: line 2"));
  CHECK(fault("1 0 0 0 0\n", 1).starts_with("fea.bad_stress_file: s.csv: line 1"));
  const std::string zeros = ",0,1,1,1,0,0,0\n";
  CHECK(
      fault("1" + zeros + "1" + zeros, 2).starts_with("fea.bad_stress_file: s.csv: line 2: tet 1"));
  for (const std::string index : {"0", "3", "-1", "1.5", "1e300"})
    CHECK(fault("1" + zeros + index + zeros, 2).starts_with("fea.bad_stress_file: s.csv: line 2"));
}

namespace {

/// One tet with one array of cell data.
std::string vtu(const std::string& arrays) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
         "byte_order=\"LittleEndian\">"
         "<UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points>"
         "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 "
         "0 0 1</DataArray>"
         "</Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 "
         "3</DataArray>"
         "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray>"
         "<DataArray type=\"UInt8\" Name=\"types\" "
         "format=\"ascii\">10</DataArray></Cells><CellData>" +
         arrays + "</CellData></Piece></UnstructuredGrid></VTKFile>\n";
}

std::string array(const std::string& name, int components, const std::string& values) {
  return "<DataArray type=\"Float64\" Name=\"" + name + "\" NumberOfComponents=\"" +
         std::to_string(components) + "\" format=\"ascii\">" + values + "</DataArray>";
}

}  // namespace

TEST_CASE("stress comes from VTU cell data as tensors of 6 or 9 components or as directions") {
  const double expected[6] = {1, 2, 3, 23, 13, 12};
  for (const std::string& text :
       {array("stress", 6, "1 2 3 12 23 13"), array("stress", 9, "1 12 13 12 2 23 13 23 3")}) {
    const StressField field = read(vtu(text), 1);
    for (int c = 0; c < 6; ++c) CHECK(field.stress(0, c) == expected[c]);
    CHECK(field.principal.row(0).norm() == doctest::Approx(1));
    CHECK(field.critical_tets == std::vector<Index>{0});
  }
  const StressField field = read(vtu(array("tau_max", 3, "0 3 4") + array("sigma_max", 1, "7")), 1);
  CHECK((field.principal.row(0).transpose() - Vec3(0, 0.6, 0.8)).norm() < 1e-15);
  CHECK(field.principal_value[0] == 7);

  CHECK(fault(vtu(array("stress", 3, "1 2 3")), 1).starts_with("fea.bad_stress_file"));
  CHECK(fault(vtu(array("tau_max", 3, "1 2 3")), 1).starts_with("fea.bad_stress_file"));
  CHECK(fault(vtu(array("tau_max", 3, "0 0 0") + array("sigma_max", 1, "7")), 1)
            .starts_with("fea.bad_stress_file"));
  CHECK(fault(vtu(array("stress", 6, "1 2 3 12 23 13")), 2).starts_with("fea.stress_count"));
}

TEST_CASE("random bytes as a stress file are an error, never a crash") {
  std::mt19937 random(11);
  const std::string alphabet = "0123456789.,- \n\teE+#\xff;x";
  for (int round = 0; round < 2000; ++round) {
    std::string text(random() % 120, ' ');
    for (char& c : text) c = alphabet[random() % alphabet.size()];
    const std::string code = fault(text, 3).substr(0, 4);
    CHECK((code.empty() || code == "fea."));
  }
  std::string zero_bytes(64, '\0');
  CHECK(fault(zero_bytes, 3).starts_with("fea."));
}

TEST_CASE(
    "the paper's stress files: principal stresses of the tensors agree with the file's own "
    "column") {
  const std::string bridge = shared_file("bridge_stress.csv"),
                    topopt = shared_file("topopt_stress.csv");
  if (bridge.empty() || topopt.empty()) {
    MESSAGE("skipped: S3_SHARED is not set");
    return;
  }
  const StressField field = read(bridge, 47520, 0.3);
  std::istringstream lines(bridge);
  std::string line;
  double worst = 0;
  while (std::getline(lines, line)) {
    const std::size_t comma = line.find(',');
    const int t = std::stoi(line.substr(0, comma)) - 1;
    const double expected = std::stod(line.substr(comma + 1));
    worst =
        std::max(worst, std::abs(field.principal_value[t] - expected) / (1 + std::abs(expected)));
  }
  CHECK(worst < 1e-4);                         // the file has six digits
  CHECK(field.critical_tets.size() == 14256);  // 30 % of 47520: more than that are in tension

  const StressField directions = read(topopt, 70505, 0.3);
  CHECK((directions.principal.rowwise().norm().array() - 1).abs().maxCoeff() < 1e-12);
  CHECK(directions.principal_value.size() == 70505);
  CHECK(fault(topopt, 70504).find("70505 tets, but the mesh has 70504") != std::string::npos);
}
