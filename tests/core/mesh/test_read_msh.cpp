#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "base/error.h"
#include "damaged_files.h"
#include "mesh/read_mesh.h"

using namespace s3;

namespace {

struct Kind {
  bool old_version;  // 2.2 or 4.1
  bool binary;
  bool big_endian = false;
};

const Kind kKinds[] = {{true, false},  {true, true},  {true, true, true},
                       {false, false}, {false, true}, {false, true, true}};

// Writes a Gmsh file section by section, in any version and encoding.
class MshText {
 public:
  explicit MshText(Kind kind) : kind_(kind) {
    text_ = std::string("$MeshFormat\n") + (kind.old_version ? "2.2 " : "4.1 ") +
            (kind.binary ? "1 8\n" : "0 8\n");
    if (kind.binary) put(std::int32_t{1}).line();
    text_ += "$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"part $Nodes\"\n$EndPhysicalNames\n";
    if (!kind.old_version) {
      text_ += "$Entities\n";
      for (int i = 0; i < 4; ++i) put(std::uint64_t{0});
      line();
      text_ += "$EndEntities\n";
    }
  }

  template <class T>
  MshText& put(T value) {
    if (!kind_.binary) {
      text_ += std::to_string(value) + " ";
      return *this;
    }
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (kind_.big_endian) bytes = {bytes.rbegin(), bytes.rend()};
    text_ += bytes;
    return *this;
  }
  void line() { text_ += "\n"; }
  void word(const std::string& text) { text_ += text + "\n"; }

  // Nodes of an entity of dimension 3, with their three parameters where the version has them.
  void nodes(const std::vector<std::int64_t>& tags, const std::vector<Vec3>& points) {
    word("$Nodes");
    if (kind_.old_version) {
      word(std::to_string(tags.size()));
      for (std::size_t v = 0; v < tags.size(); ++v) {
        put(static_cast<std::int32_t>(tags[v]));
        point(points[v]);
        if (!kind_.binary) line();
      }
    } else {
      const auto half = static_cast<std::uint64_t>(tags.size() / 2);
      put(std::uint64_t{2}).put(std::uint64_t{tags.size()}).put(std::uint64_t{1});
      put(std::uint64_t{100});
      for (const std::uint64_t begin : {std::uint64_t{0}, half}) {
        const std::uint64_t end = begin == 0 ? half : tags.size();
        put(std::int32_t{3}).put(std::int32_t{1}).put(std::int32_t{begin == 0}).put(end - begin);
        for (std::uint64_t v = begin; v < end; ++v) put(static_cast<std::uint64_t>(tags[v]));
        for (std::uint64_t v = begin; v < end; ++v) {
          point(points[v]);
          if (begin == 0) point(Vec3(0.1, 0.2, 0.3));
        }
      }
    }
    line();
    word("$EndNodes");
  }

  struct Block {
    int type;
    std::vector<std::vector<std::int64_t>> elements;
  };

  void elements(const std::vector<Block>& blocks) {
    std::size_t count = 0;
    for (const Block& block : blocks) count += block.elements.size();
    word("$Elements");
    if (kind_.old_version)
      word(std::to_string(count));
    else
      put(std::uint64_t{blocks.size()})
          .put(std::uint64_t{count})
          .put(std::uint64_t{1})
          .put(std::uint64_t{count});
    for (const Block& block : blocks) {
      const auto size = block.elements.size();
      if (!kind_.old_version)
        put(std::int32_t{3})
            .put(std::int32_t{1})
            .put(std::int32_t{block.type})
            .put(std::uint64_t{size});
      else if (kind_.binary)
        put(std::int32_t{block.type}).put(static_cast<std::int32_t>(size)).put(std::int32_t{2});
      for (const auto& element : block.elements) {
        if (!kind_.old_version) {
          put(std::uint64_t{9});
        } else {
          put(std::int32_t{9});
          if (!kind_.binary) put(block.type).put(2);
          put(std::int32_t{1}).put(std::int32_t{1});
        }
        for (const std::int64_t tag : element)
          if (kind_.old_version)
            put(static_cast<std::int32_t>(tag));
          else
            put(static_cast<std::uint64_t>(tag));
        if (!kind_.binary) line();
      }
    }
    line();
    word("$EndElements");
  }

  std::string& text() { return text_; }

 private:
  void point(const Vec3& p) {
    for (int k = 0; k < 3; ++k) put(p[k]);
  }

  Kind kind_;
  std::string text_;
};

const std::vector<Vec3> kPoints = {{0, 0, 0}, {7, 7, 7}, {1, 0, 0},
                                   {0, 1, 0}, {0, 0, 1}, {0.25, 1, 1}};
const std::vector<std::int64_t> kTags = {10, 50, 2, 30, 41, 5};

// Two tets and some of their faces; the node 50 belongs to nothing but a point.
std::string two_tets(Kind kind) {
  MshText msh(kind);
  msh.nodes(kTags, kPoints);
  msh.elements(
      {{15, {{50}}}, {2, {{10, 30, 2}, {10, 2, 41}}}, {4, {{10, 2, 30, 41}, {2, 30, 41, 5}}}});
  msh.word("$NodeData");
  msh.word("anything");
  msh.word("$EndNodeData");
  return msh.text();
}

std::string error_of(const std::string& text) {
  try {
    test::read(text, "a.msh");
  } catch (const Error& e) {
    CHECK(e.kind == ErrorKind::input);
    CHECK(!e.hint.empty());
    return e.code + " | " + e.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("the tets of a Gmsh file read the same in every version and encoding") {
  for (const Kind& kind : kKinds) {
    CAPTURE(kind.old_version);
    CAPTURE(kind.binary);
    CAPTURE(kind.big_endian);
    const ModelFile model = test::read(two_tets(kind), "part");
    CHECK(model.format == "msh");
    CHECK(model.is_volume);
    CHECK(model.warnings.empty());
    REQUIRE(model.vertices.rows() == 5);  // without the point of its own
    CHECK(model.vertices.row(4) == Points::RowXpr::PlainObject(0.25, 1, 1));
    REQUIRE(model.tets.rows() == 2);
    CHECK(model.tets.row(0) == Tets::RowXpr::PlainObject(0, 1, 2, 3));
    CHECK(model.tets.row(1) == Tets::RowXpr::PlainObject(1, 2, 3, 4));
  }
}

TEST_CASE("a Gmsh file without solids gives its triangles and quadrangles") {
  for (const Kind& kind : kKinds) {
    MshText msh(kind);
    msh.nodes({1, 2, 3, 4, 5, 6},
              {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {9, 9, 9}});
    msh.elements({{3, {{1, 2, 3, 4}}}, {2, {{2, 5, 3}}}, {1, {{1, 2}}}});
    const ModelFile model = test::read(msh.text(), "a.msh");
    CHECK(!model.is_volume);
    CHECK(model.surface.vertices.rows() == 5);
    REQUIRE(model.surface.triangles.rows() == 3);
    CHECK(surface_area(model.surface) == doctest::Approx(1.5));
    CHECK(model.part_of_triangle.size() == 3);
  }
}

TEST_CASE("curved tets of a Gmsh file give their corners and a warning") {
  for (const Kind& kind : kKinds) {
    MshText msh(kind);
    msh.nodes({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, {{0, 0, 0},
                                                {1, 0, 0},
                                                {0, 1, 0},
                                                {0, 0, 1},
                                                {.5, 0, 0},
                                                {.5, .5, 0},
                                                {0, .5, 0},
                                                {0, 0, .5},
                                                {0, .5, .5},
                                                {.5, 0, .5}});
    msh.elements({{11, {{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}}}});
    const ModelFile model = test::read(msh.text(), "a.msh");
    CHECK(model.vertices.rows() == 4);
    CHECK(model.tets.row(0) == Tets::RowXpr::PlainObject(0, 1, 2, 3));
    REQUIRE(model.warnings.size() == 1);
    CHECK(model.warnings[0].code == "mesh.curved_elements");
  }
}

TEST_CASE("Gmsh errors say what is wrong and where") {
  const std::string old_text = two_tets({true, false}), new_text = two_tets({false, false});
  const auto replaced = test::replaced;
  CHECK(error_of(replaced(old_text, "2.2", "1.0")).find("version 1.0") != std::string::npos);
  CHECK(error_of(replaced(old_text, "2.2", "4")).find("version 4") != std::string::npos);
  CHECK(error_of(replaced(old_text, "$Nodes\n6", "$Nodes\n4000000000"))
            .find("too short for 4000000000 nodes") != std::string::npos);
  CHECK(error_of(replaced(old_text, "$Elements\n5", "$Elements\n4000000000"))
            .find("too short for 4000000000 elements") != std::string::npos);
  CHECK(error_of(replaced(new_text, "3 1 1 3", "3 1 1 4000000000"))
            .find("too short for 4000000000 nodes") != std::string::npos);
  CHECK(error_of(replaced(new_text, "3 1 4 2", "3 1 4 4000000000"))
            .find("too short for 4000000000 elements") != std::string::npos);
  CHECK(error_of(replaced(old_text, "2 30 41 5", "2 30 41 6")).find("names node 6") !=
        std::string::npos);
  CHECK(error_of(replaced(old_text, "\n50 ", "\n10 ")).find("node 10 is there twice") !=
        std::string::npos);
  CHECK(
      error_of(replaced(old_text, "9 4 2", "9 77 2")).find("a.msh: line 23: elements of unknown") !=
      std::string::npos);
  CHECK(error_of(old_text.substr(0, old_text.size() - 14)).find("within the section $NodeData") !=
        std::string::npos);
  MshText wedge({false, true});
  wedge.nodes({1, 2, 3, 4, 5, 6},
              {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
  wedge.elements({{6, {{1, 2, 3, 4, 5, 6}}}});
  CHECK(error_of(wedge.text()).find("solids that are no tets") != std::string::npos);
}

TEST_CASE("a Gmsh file cut or damaged anywhere gives an error or a mesh in range") {
  for (const Kind& kind : kKinds) test::check_damage(two_tets(kind), "a.msh");
}
