#include <doctest/doctest.h>

#include <cstring>
#include <string>
#include <vector>

#include "base/error.h"
#include "damaged_files.h"
#include "mesh/read_mesh.h"

using namespace s3;

namespace {

enum class Encoding { ascii, little, big };

// A PLY file in any encoding; values are put one after the other.
class PlyText {
 public:
  explicit PlyText(Encoding encoding) : encoding_(encoding) {}

  std::string header(const std::string& elements, const char* line_end = "\n") const {
    const char* names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    std::string text = "ply\nformat " + std::string(names[static_cast<int>(encoding_)]) +
                       " 1.0\ncomment made by a test\nobj_info none\n" + elements + "end_header\n";
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;
         at += std::strlen(line_end))
      text.replace(at, 1, line_end);
    return text;
  }
  template <class T>
  PlyText& put(T value) {
    if (encoding_ == Encoding::ascii) {
      body_ += std::to_string(value) + " ";
      return *this;
    }
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (encoding_ == Encoding::big) bytes = {bytes.rbegin(), bytes.rend()};
    body_ += bytes;
    return *this;
  }
  PlyText& end_line() {
    if (encoding_ == Encoding::ascii) body_.back() = '\n';
    return *this;
  }
  const std::string& body() const { return body_; }

 private:
  Encoding encoding_;
  std::string body_;
};

const double kCorners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.5}};
const int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

// The same tetrahedron with properties of every kind, in an unusual order, around what counts.
std::string rich_tetrahedron(Encoding encoding, const char* line_end = "\n") {
  PlyText ply(encoding);
  for (int i = 0; i < 2; ++i)
    ply.put(std::int8_t{3}).put(1.5f).put(2.5f).put(3.5f).put(std::uint16_t{7}).end_line();
  for (const auto& p : kCorners)
    ply.put(std::uint8_t{200})
        .put(p[2])
        .put(static_cast<float>(p[0]))
        .put(p[1])
        .put(std::int16_t{-1})
        .end_line();
  for (const auto& f : kFaces)
    ply.put(0.25f)
        .put(std::uint32_t{3})
        .put(std::int16_t(f[0]))
        .put(std::int16_t(f[1]))
        .put(std::int16_t(f[2]))
        .put(std::uint8_t{2})
        .put(0.5)
        .put(0.5)
        .end_line();
  return ply.header(
             "element camera 2\nproperty list char float axes\nproperty ushort id\n"
             "element vertex 4\nproperty uchar red\nproperty double z\nproperty float x\n"
             "property double y\nproperty short label\n"
             "element face 4\nproperty float quality\nproperty list uint short vertex_indices\n"
             "property list uchar double texcoord\nelement nothing 4000000000\n",
             line_end) +
         ply.body();
}

std::string plain_tetrahedron(Encoding encoding) {
  PlyText ply(encoding);
  for (const auto& p : kCorners)
    for (const double x : p) ply.put(static_cast<float>(x));
  for (const auto& f : kFaces) ply.put(std::uint8_t{3}).put(f[0]).put(f[1]).put(f[2]).end_line();
  return ply.header(
             "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 4\nproperty list uchar int vertex_index\n") +
         ply.body();
}

std::string error_of(const std::string& text) {
  try {
    test::read(text, "a.ply");
  } catch (const Error& e) {
    CHECK(e.kind == ErrorKind::input);
    CHECK(!e.hint.empty());
    return e.code + " | " + e.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("a PLY file reads the same in every encoding, whatever else it holds") {
  for (const Encoding encoding : {Encoding::ascii, Encoding::little, Encoding::big})
    for (const std::string& text :
         {plain_tetrahedron(encoding), rich_tetrahedron(encoding),
          rich_tetrahedron(encoding, encoding == Encoding::ascii ? "\r\n" : "\n")}) {
      CAPTURE(static_cast<int>(encoding));
      const ModelFile model = test::read(text, "part");
      CHECK(model.format == "ply");
      CHECK(!model.is_volume);
      REQUIRE(model.surface.vertices.rows() == 4);
      REQUIRE(model.surface.triangles.rows() == 4);
      for (int v = 0; v < 4; ++v)
        for (int k = 0; k < 3; ++k) CHECK(model.surface.vertices(v, k) == kCorners[v][k]);
      for (int f = 0; f < 4; ++f)
        for (int i = 0; i < 3; ++i) CHECK(model.surface.triangles(f, i) == kFaces[f][i]);
      CHECK(model.part_names == std::vector<std::string>{""});
      CHECK(model.part_of_triangle == std::vector<Index>{0, 0, 0, 0});
    }
}

TEST_CASE("polygons and triangle strips of a PLY file become triangles") {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::string points = "0 0 0 2 0 0 2 1 0 1 2 0 0 1 0\n";
  const ModelFile pentagon =
      test::read(head + "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                     points + "5 0 1 2 3 4\n",
                 "a.ply");
  CHECK(pentagon.surface.triangles.rows() == 3);
  CHECK(surface_area(pentagon.surface) == doctest::Approx(3));

  // Two strips; all triangles keep one orientation.
  const ModelFile strips =
      test::read(head + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
                     points + "8 0 1 4 2 -1 4 2 3\n",
                 "a.ply");
  REQUIRE(strips.surface.triangles.rows() == 3);
  CHECK(surface_area(strips.surface) == doctest::Approx(3));
  for (int f = 0; f < 3; ++f)
    CHECK(triangle_normal_2a(strips.surface.vertices, strips.surface.triangles.row(f)).z() > 0);
}

TEST_CASE("faces of a PLY file may come before its vertices") {
  const std::string text =
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
      "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n";
  CHECK(surface_area(test::read(text, "a.ply").surface) == doctest::Approx(0.5));
}

TEST_CASE("PLY errors name the file and the place") {
  const std::string good = plain_tetrahedron(Encoding::ascii);
  const std::string binary = plain_tetrahedron(Encoding::little);
  CHECK(error_of(good) == "no error");
  const auto replaced = test::replaced;
  CHECK(error_of(replaced(good, "vertex 4", "vertex 4294967295"))
            .find("too short for 4294967295 rows of 'vertex'") != std::string::npos);
  CHECK(error_of(replaced(binary, "face 4", "face 4294967295"))
            .find("too short for 4294967295 rows of 'face'") != std::string::npos);
  CHECK(error_of(replaced(binary, "vertex 4", "vertex 99999999999999999999")).find("line 5") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "property float y", "property float w")).find("lack x, y or z") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "float x", "real x")).find("line 6: 'real' is no type") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "ascii", "text")).find("'text' is no encoding") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "0 2 1", "0 2 4")).find("names vertex 4, the file has 4") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "0 2 1", "0 2 -1")).find("line 12: vertex -1") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "3 0 2 1", "2 0 2")).find("a face with 2 corners") !=
        std::string::npos);
  CHECK(error_of(good.substr(0, good.size() - 4)).find("a.ply: line") != std::string::npos);
  CHECK(error_of(binary.substr(0, binary.size() - 4)).find("a.ply: byte") != std::string::npos);
  CHECK(error_of("ply\nformat ascii 1.0\nend_header\n").find("mesh.empty_file") == 0);
}

TEST_CASE("a PLY file cut or damaged anywhere gives an error or a mesh in range") {
  for (const Encoding encoding : {Encoding::ascii, Encoding::little, Encoding::big})
    test::check_damage(rich_tetrahedron(encoding), "a.ply");
}
