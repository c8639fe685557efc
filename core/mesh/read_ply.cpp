// The format: Turk, "The PLY Polygon File Format", Stanford University, 1994.
#include <algorithm>
#include <limits>
#include <vector>

#include "mesh/mesh_builder.h"
#include "mesh/mixed_reader.h"
#include "mesh/read_mesh.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

struct Property {
  std::string_view name;
  Number type = Number::float32;      // of the value, or of a list's items
  Number count_type = Number::uint8;  // of a list's length
  bool is_list = false;
};

struct Element {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

Number take_type(MixedReader& reader, std::string_view& line) {
  static constexpr std::pair<std::string_view, Number> kNames[] = {
      {"char", Number::int8},       {"int8", Number::int8},       {"uchar", Number::uint8},
      {"uint8", Number::uint8},     {"short", Number::int16},     {"int16", Number::int16},
      {"ushort", Number::uint16},   {"uint16", Number::uint16},   {"int", Number::int32},
      {"int32", Number::int32},     {"uint", Number::uint32},     {"uint32", Number::uint32},
      {"float", Number::float32},   {"float32", Number::float32}, {"double", Number::float64},
      {"float64", Number::float64}, {"int64", Number::int64},     {"uint64", Number::uint64}};
  const std::string_view word = take_word(line);
  for (const auto& [name, type] : kNames)
    if (name == word) return type;
  reader.fail(quoted(word) + " is no type of a property");
}

Property take_property(MixedReader& reader, std::string_view line) {
  Property property;
  std::string_view ahead = line;
  if (take_word(ahead) == "list") {
    line = ahead;
    property.is_list = true;
    property.count_type = take_type(reader, line);
  }
  property.type = take_type(reader, line);
  property.name = take_word(line);
  if (property.name.empty()) reader.fail("a property without a name");
  return property;
}

MixedReader::Mode take_encoding(MixedReader& reader, std::string_view line) {
  const std::string_view word = take_word(line);
  if (word == "ascii") return MixedReader::Mode::text;
  if (word == "binary_little_endian") return MixedReader::Mode::little_endian;
  if (word == "binary_big_endian") return MixedReader::Mode::big_endian;
  reader.fail(quoted(word) + " is no encoding of PLY");
}

Element take_element(MixedReader& reader, std::string_view line) {
  Element element;
  element.name = take_word(line);
  const std::string_view word = take_word(line);
  const std::optional<std::int64_t> count = parse_integer(word);
  if (!count || *count < 0) reader.fail(quoted(word) + " is no number of elements");
  element.count = static_cast<std::uint64_t>(*count);
  return element;
}

// Leaves the reader at the first value, in the file's encoding.
std::vector<Element> take_header(MixedReader& reader) {
  std::vector<Element> elements;
  std::optional<MixedReader::Mode> mode;
  if (reader.take_line() != "ply") reader.fail("a PLY file begins with 'ply'");
  for (;;) {
    std::string_view line = reader.take_line();
    const std::string_view keyword = take_word(line);
    if (keyword == "end_header") break;
    if (keyword == "format") {
      mode = take_encoding(reader, line);
    } else if (keyword == "element") {
      elements.push_back(take_element(reader, line));
    } else if (keyword == "property") {
      if (elements.empty()) reader.fail("a property before the first element");
      elements.back().properties.push_back(take_property(reader, line));
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      reader.fail(quoted(keyword) + " in the header");
    }
  }
  if (!mode) reader.fail("the header names no encoding");
  reader.mode = *mode;
  return elements;
}

// The fewest values or bytes that one row of the element takes.
std::uint64_t least_bytes(const Element& element) {
  std::uint64_t bytes = 0;
  for (const Property& p : element.properties) bytes += size_of(p.is_list ? p.count_type : p.type);
  return bytes;
}

std::uint64_t take_list_length(MixedReader& reader, const Property& list) {
  const std::int64_t length = reader.take_integer(list.count_type, "the length of a list");
  if (length < 0) reader.fail("a list of length " + std::to_string(length));
  reader.require_room(static_cast<std::uint64_t>(length), size_of(list.type), "values in a list");
  return static_cast<std::uint64_t>(length);
}

void skip_property(MixedReader& reader, const Property& property) {
  reader.skip(property.type, property.is_list ? take_list_length(reader, property) : 1);
}

void skip_element(MixedReader& reader, const Element& element) {
  const bool has_lists = std::any_of(element.properties.begin(), element.properties.end(),
                                     [](const Property& p) { return p.is_list; });
  if (!has_lists) {
    for (const Property& p : element.properties) reader.skip(p.type, element.count);
    return;
  }
  for (std::uint64_t row = 0; row < element.count; ++row)
    for (const Property& p : element.properties) skip_property(reader, p);
}

void take_vertices(MixedReader& reader, const Element& element, MeshBuilder& mesh) {
  std::vector<int> axes;  // of each property; −1 for others
  int found = 0;
  for (const Property& p : element.properties) {
    const std::size_t axis = p.name.size() == 1 ? std::string_view("xyz").find(p.name) : 3;
    const bool is_axis = axis < 3 && !p.is_list;
    axes.push_back(is_axis ? static_cast<int>(axis) : -1);
    if (is_axis) found |= 1 << axis;
  }
  if (found != 7) reader.fail("the vertices lack x, y or z");
  for (std::uint64_t v = 0; v < element.count; ++v) {
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if (axes[i] >= 0)
        p[axes[i]] = reader.take_double(element.properties[i].type, "a coordinate");
      else
        skip_property(reader, element.properties[i]);
    }
    mesh.add_vertex(p);
  }
}

// Vertices may follow; read_ply checks the upper bound at the end.
Index take_corner(MixedReader& reader, const Property& list) {
  const std::int64_t corner = reader.take_integer(list.type, "a vertex number");
  if (corner < 0 || corner > std::numeric_limits<Index>::max())
    reader.fail("vertex " + std::to_string(corner) + " does not exist");
  return static_cast<Index>(corner);
}

void take_polygon(MixedReader& reader, const Property& list, MeshBuilder& mesh) {
  const std::uint64_t corners = take_list_length(reader, list);
  if (corners < 3) reader.fail("a face with " + std::to_string(corners) + " corners");
  const Index first = take_corner(reader, list);
  Index previous = take_corner(reader, list);
  for (std::uint64_t i = 2; i < corners; ++i) {
    const Index corner = take_corner(reader, list);
    mesh.add_triangle(first, previous, corner);
    previous = corner;
  }
}

// Every three consecutive corners are a triangle, of alternating order; −1 begins a new strip.
void take_strips(MixedReader& reader, const Property& list, MeshBuilder& mesh) {
  const std::uint64_t length = take_list_length(reader, list);
  Index last[2] = {};
  std::uint64_t corners = 0;
  for (std::uint64_t i = 0; i < length; ++i) {
    const std::int64_t corner = reader.take_integer(list.type, "a vertex number");
    if (corner == -1) {
      corners = 0;
      continue;
    }
    if (corner < 0 || corner > std::numeric_limits<Index>::max())
      reader.fail("vertex " + std::to_string(corner) + " does not exist");
    const Index c = static_cast<Index>(corner);
    const bool turned = corners % 2 == 1;
    if (corners >= 2) mesh.add_triangle(last[turned ? 1 : 0], last[turned ? 0 : 1], c);
    last[0] = last[1];
    last[1] = c;
    ++corners;
  }
}

void take_faces(MixedReader& reader, const Element& element, MeshBuilder& mesh) {
  const bool strips = element.name == "tristrips";
  for (std::uint64_t f = 0; f < element.count; ++f)
    for (const Property& p : element.properties) {
      if (!p.is_list || (p.name != "vertex_indices" && p.name != "vertex_index"))
        skip_property(reader, p);
      else if (strips)
        take_strips(reader, p, mesh);
      else
        take_polygon(reader, p, mesh);
    }
}

}  // namespace

TriMesh read_ply(std::span<const std::byte> bytes, std::string_view file_name) {
  MixedReader reader(bytes, file_name);
  const std::vector<Element> elements = take_header(reader);
  MeshBuilder builder;
  for (const Element& element : elements) {
    if (element.properties.empty()) continue;
    reader.require_room(element.count, least_bytes(element),
                        "rows of '" + std::string(element.name.substr(0, 40)) + "'");
    if (element.name == "vertex")
      take_vertices(reader, element, builder);
    else if (element.name == "face" || element.name == "tristrips")
      take_faces(reader, element, builder);
    else
      skip_element(reader, element);
  }
  const Index largest = builder.largest_corner();
  if (largest >= 0 && static_cast<std::size_t>(largest) >= builder.vertex_count())
    reader.fail("a face names vertex " + std::to_string(largest) + ", the file has " +
                std::to_string(builder.vertex_count()));
  return builder.take();
}

}  // namespace s3
