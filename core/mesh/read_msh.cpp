// The format: Gmsh Reference Manual, chapter "Gmsh file formats", versions 2.2 and 4.1.
#include <algorithm>
#include <limits>
#include <vector>

#include "base/error.h"
#include "mesh/mixed_reader.h"
#include "mesh/read_mesh.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

struct ElementType {
  int nodes = 0;      // what the file lists
  int dimension = 0;  // 3: solids
  int corners = 0;    // of triangles and quadrangles, and of tets; 0 where nothing is taken
};

// By Gmsh's number of the type. The nodes of curved elements follow their corners.
constexpr ElementType kElementTypes[] = {
    {0, 0, 0},   // (no type 0)
    {2, 1, 0},   // line
    {3, 2, 3},   // triangle
    {4, 2, 4},   // quadrangle
    {4, 3, 4},   // tet
    {8, 3, 0},   // hexahedron
    {6, 3, 0},   // prism
    {5, 3, 0},   // pyramid
    {3, 1, 0},   // line, order 2
    {6, 2, 3},   // triangle, order 2
    {9, 2, 4},   // quadrangle, order 2
    {10, 3, 4},  // tet, order 2
    {27, 3, 0},  // hexahedron, order 2
    {18, 3, 0},  // prism, order 2
    {14, 3, 0},  // pyramid, order 2
    {1, 0, 0},   // point
    {8, 2, 4},   // quadrangle, order 2, without its centre
    {20, 3, 0},  // hexahedron, order 2, edges only
    {15, 3, 0},  // prism, order 2, edges only
    {13, 3, 0},  // pyramid, order 2, edges only
    {9, 2, 3},   // triangle, order 3, without its centre
    {10, 2, 3},  // triangle, order 3
    {12, 2, 3},  // triangle, order 4, without its inside
    {15, 2, 3},  // triangle, order 4
    {15, 2, 3},  // triangle, order 5, without its inside
    {21, 2, 3},  // triangle, order 5
    {4, 1, 0},   // line, order 3
    {5, 1, 0},   // line, order 4
    {6, 1, 0},   // line, order 5
    {20, 3, 4},  // tet, order 3
    {35, 3, 4},  // tet, order 4
    {56, 3, 4},  // tet, order 5
};

class MshReader {
 public:
  MshReader(std::span<const std::byte> bytes, std::string_view file_name)
      : reader_(bytes, file_name), file_name_(file_name) {}

  ModelFile read() {
    take_format();
    while (!reader_.at_end()) {
      const std::string_view section = take_section_name();
      if (section.empty()) continue;
      if (section == "Nodes")
        old_version_ ? take_nodes_2() : take_nodes_4();
      else if (section == "Elements")
        old_version_ ? take_elements_2() : take_elements_4();
      else if (!reader_.skip_past("$End" + std::string(section)))
        reader_.fail("the file ends within the section $" + std::string(section.substr(0, 40)));
      else
        continue;
      if (reader_.take_word() != "$End" + std::string(section))
        reader_.fail("expected $End" + std::string(section));
    }
    if (!tets_.empty() || other_solids_) return volume();
    return surface();
  }

 private:
  static constexpr Number kInt = Number::int32, kSize = Number::uint64, kReal = Number::float64;

  std::uint64_t take_count(Number type, std::string_view what) {
    const std::int64_t count = reader_.take_integer(type, what);
    if (count < 0) reader_.fail(std::to_string(count) + " " + std::string(what));
    return static_cast<std::uint64_t>(count);
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file",
                std::string(file_name_) + ": " + what,
                "Save the mesh from Gmsh as version 4.1 or 2.2 (File > Export, .msh)");
  }

  // Words that are no "$Section" between sections are left out, as Gmsh does.
  std::string_view take_section_name() {
    const MixedReader::Mode mode = std::exchange(reader_.mode, MixedReader::Mode::text);
    std::string_view name;
    const std::string_view word = reader_.take_word();
    if (word.starts_with('$')) name = word.substr(1);
    reader_.mode = mode;
    return name;
  }

  void take_format() {
    if (reader_.take_word() != "$MeshFormat") refuse("no $MeshFormat in the first line");
    const std::string_view version = reader_.take_word();
    if (version != "2.2" && version != "4.1" && version != "2")
      refuse("a Gmsh file of version " + std::string(version.substr(0, 40)));
    old_version_ = version != "4.1";
    const std::int64_t binary = reader_.take_integer(kInt, "the file's kind");
    if (reader_.take_integer(kInt, "the size of a number") != 8)
      refuse("the numbers are not of 8 bytes");
    if (binary == 1) {
      reader_.take_line();
      reader_.mode = MixedReader::Mode::little_endian;
      const std::int64_t one = reader_.take_integer(kInt, "the mark of the byte order");
      if (one == 1 << 24)
        reader_.mode = MixedReader::Mode::big_endian;
      else if (one != 1)
        reader_.fail("no mark of the byte order");
    } else if (binary != 0) {
      refuse("neither text nor binary");
    }
    if (reader_.take_word() != "$EndMeshFormat") reader_.fail("expected $EndMeshFormat");
  }

  // A binary section begins right behind the line of its name.
  void begin_section() {
    if (reader_.mode != MixedReader::Mode::text) reader_.take_line();
  }

  void take_coordinates() {
    for (int k = 0; k < 3; ++k) coordinates_.push_back(reader_.take_double(kReal, "a coordinate"));
  }

  void take_nodes_2() {
    // Even a binary file has this number as text.
    const MixedReader::Mode mode = std::exchange(reader_.mode, MixedReader::Mode::text);
    const std::uint64_t count = take_count(kInt, "nodes");
    reader_.take_line();
    reader_.mode = mode;
    reader_.require_room(count, 28, "nodes");
    for (std::uint64_t v = 0; v < count; ++v) {
      node_tags_.push_back(reader_.take_integer(kInt, "a node's number"));
      take_coordinates();
    }
  }

  void take_nodes_4() {
    begin_section();
    const std::uint64_t blocks = take_count(kSize, "blocks of nodes");
    reader_.skip(kSize, 3);  // how many in all, least and largest number
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = reader_.take_integer(kInt, "an entity's dimension");
      reader_.skip(kInt, 1);  // the entity's number
      const bool parametric = reader_.take_integer(kInt, "whether nodes have parameters") != 0;
      const std::uint64_t count = take_count(kSize, "nodes");
      if (dimension < 0 || dimension > 3)
        reader_.fail("an entity of dimension " + std::to_string(dimension));
      reader_.require_room(count, 32, "nodes");
      for (std::uint64_t v = 0; v < count; ++v)
        node_tags_.push_back(reader_.take_integer(kSize, "a node's number"));
      for (std::uint64_t v = 0; v < count; ++v) {
        take_coordinates();
        if (parametric) reader_.skip(kReal, static_cast<std::uint64_t>(dimension));
      }
    }
  }

  ElementType take_type() {
    const std::int64_t number = reader_.take_integer(kInt, "the type of an element");
    if (number < 1 || number >= static_cast<std::int64_t>(std::size(kElementTypes)))
      reader_.fail("elements of unknown type " + std::to_string(number));
    return kElementTypes[number];
  }

  // The nodes of one element; `tag_type` is how node numbers are stored.
  void take_element(const ElementType& type, Number tag_type) {
    std::vector<std::int64_t>& corners = type.dimension == 3 ? tets_ : triangles_;
    if (type.dimension == 3 && type.corners == 0) other_solids_ = true;
    if (type.corners > 0 && type.nodes > 4) curved_ = true;
    std::int64_t node[4] = {};
    for (int i = 0; i < type.corners; ++i) node[i] = reader_.take_integer(tag_type, "a node");
    reader_.skip(tag_type, static_cast<std::uint64_t>(type.nodes - type.corners));
    if (type.dimension == 3 && type.corners == 4) {
      corners.insert(corners.end(), node, node + 4);
    } else if (type.corners >= 3) {
      corners.insert(corners.end(), node, node + 3);
      if (type.corners == 4) corners.insert(corners.end(), {node[0], node[2], node[3]});
    }
  }

  void take_elements_2() {
    const MixedReader::Mode mode = std::exchange(reader_.mode, MixedReader::Mode::text);
    const std::uint64_t count = take_count(kInt, "elements");
    reader_.take_line();
    reader_.mode = mode;
    reader_.require_room(count, 8, "elements");
    if (mode == MixedReader::Mode::text) {
      for (std::uint64_t e = 0; e < count; ++e) {
        reader_.skip(kInt, 1);  // the element's number
        const ElementType type = take_type();
        reader_.skip(kInt, take_count(kInt, "tags"));
        take_element(type, kInt);
      }
      return;
    }
    for (std::uint64_t e = 0; e < count;) {
      const ElementType type = take_type();
      const std::uint64_t following = take_count(kInt, "elements");
      const std::uint64_t tags = take_count(kInt, "tags");
      if (following == 0 || following > count - e)
        reader_.fail(std::to_string(following) + " elements where " + std::to_string(count - e) +
                     " are left");
      for (std::uint64_t i = 0; i < following; ++i) {
        reader_.skip(kInt, 1 + tags);
        take_element(type, kInt);
      }
      e += following;
    }
  }

  void take_elements_4() {
    begin_section();
    const std::uint64_t blocks = take_count(kSize, "blocks of elements");
    reader_.skip(kSize, 3);
    for (std::uint64_t b = 0; b < blocks; ++b) {
      reader_.skip(kInt, 2);  // the entity's dimension and number
      const ElementType type = take_type();
      const std::uint64_t count = take_count(kSize, "elements");
      reader_.require_room(count, 16, "elements");
      for (std::uint64_t e = 0; e < count; ++e) {
        reader_.skip(kSize, 1);
        take_element(type, kSize);
      }
    }
  }

  /// Turns node numbers into rows of `vertices`, which keeps the used nodes in the file's order.
  std::vector<Index> resolved(const std::vector<std::int64_t>& corners, Points& vertices) const {
    std::vector<std::pair<std::int64_t, std::size_t>> by_tag(node_tags_.size());
    for (std::size_t v = 0; v < by_tag.size(); ++v) by_tag[v] = {node_tags_[v], v};
    std::sort(by_tag.begin(), by_tag.end());
    for (std::size_t i = 1; i < by_tag.size(); ++i)
      if (by_tag[i].first == by_tag[i - 1].first)
        refuse("node " + std::to_string(by_tag[i].first) + " is there twice");
    std::vector<std::size_t> rows;
    rows.reserve(corners.size());
    std::vector<Index> new_row(node_tags_.size(), -1);
    for (const std::int64_t tag : corners) {
      const auto found =
          std::lower_bound(by_tag.begin(), by_tag.end(), std::pair(tag, std::size_t{0}));
      if (found == by_tag.end() || found->first != tag)
        refuse("an element names node " + std::to_string(tag) + ", which is not there");
      rows.push_back(found->second);
      new_row[found->second] = 0;
    }
    Index used = 0;
    for (Index& row : new_row)
      if (row == 0) row = used++;
    vertices.resize(used, 3);
    for (std::size_t v = 0; v < new_row.size(); ++v)
      if (new_row[v] >= 0)
        vertices.row(new_row[v]) = Eigen::Map<const Vec3>(coordinates_.data() + 3 * v);
    std::vector<Index> result;
    result.reserve(rows.size());
    for (const std::size_t row : rows) result.push_back(new_row[row]);
    return result;
  }

  ModelFile volume() {
    if (other_solids_)
      throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file",
                  std::string(file_name_) + " has solids that are no tets",
                  "Mesh the part with tetrahedra only, or give its surface");
    ModelFile model;
    model.is_volume = true;
    const std::vector<Index> corners = resolved(tets_, model.vertices);
    model.tets = Eigen::Map<const Tets>(corners.data(), rows(corners, 4), 4);
    warn_if_curved(model);
    return model;
  }

  ModelFile surface() {
    ModelFile model;
    const std::vector<Index> corners = resolved(triangles_, model.surface.vertices);
    model.surface.triangles = Eigen::Map<const Triangles>(corners.data(), rows(corners, 3), 3);
    warn_if_curved(model);
    return model;
  }

  static Eigen::Index rows(const std::vector<Index>& flat, std::size_t columns) {
    return static_cast<Eigen::Index>(flat.size() / columns);
  }

  void warn_if_curved(ModelFile& model) const {
    if (curved_)
      model.warnings.push_back({"mesh.curved_elements",
                                std::string(file_name_) +
                                    " has elements of higher order; only their corners are used, "
                                    "with straight edges: mesh finer where this is too coarse",
                                {}});
  }

  MixedReader reader_;
  std::string_view file_name_;
  bool old_version_ = false, other_solids_ = false, curved_ = false;
  std::vector<std::int64_t> node_tags_;
  std::vector<double> coordinates_;
  std::vector<std::int64_t> tets_, triangles_;  // node numbers
};

}  // namespace

ModelFile read_msh(std::span<const std::byte> bytes, std::string_view file_name) {
  return MshReader(bytes, file_name).read();
}

}  // namespace s3
