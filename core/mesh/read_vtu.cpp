// The format: "VTK File Formats", section "XML File Formats", kitware.com/products/books.
#include "mesh/read_vtu.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

constexpr double kTetCell = 10;  // VTK_TETRA

using Attributes = std::map<std::string, std::string, std::less<>>;

struct Tag {
  std::string name;  // "/Piece" for a closing tag
  Attributes attributes;
  bool self_closed = false;

  std::string_view operator[](std::string_view key) const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? std::string_view() : std::string_view(found->second);
  }
};

// Position in the text; every message is about the current line.
struct Cursor {
  std::string_view text, file_name;
  std::size_t at = 0;

  [[noreturn]] void fail(const std::string& what, const std::string& hint = {}) const {
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file",
                std::string(file_name) + ": line " + std::to_string(line) + ": " + what,
                hint.empty() ? "The file is damaged; export the mesh again" : hint);
  }
};

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

void skip_spaces(Cursor& c) {
  while (c.at < c.text.size() && is_space(c.text[c.at])) ++c.at;
}

// Skips past `end`; the text's end where there is none.
void skip_past(Cursor& c, std::string_view end) {
  const std::size_t found = c.text.find(end, c.at);
  c.at = found == std::string_view::npos ? c.text.size() : found + end.size();
}

void read_attribute(Cursor& c, Tag& tag) {
  const std::size_t begin = c.at;
  while (c.at < c.text.size() && c.text[c.at] != '=' && c.text[c.at] != '>' &&
         !is_space(c.text[c.at]))
    ++c.at;
  const std::string_view key = c.text.substr(begin, c.at - begin);
  skip_spaces(c);
  if (key.empty() || c.at >= c.text.size() || c.text[c.at] != '=') c.fail("expected an attribute");
  ++c.at;
  skip_spaces(c);
  const char quote = c.at < c.text.size() ? c.text[c.at] : '\0';
  if (quote != '"' && quote != '\'')
    c.fail("expected a quoted value of '" + std::string(key.substr(0, 40)) + "'");
  const std::size_t end = c.text.find(quote, c.at + 1);
  if (end == std::string_view::npos) c.fail("a quote without its end");
  tag.attributes.emplace(key, c.text.substr(c.at + 1, end - c.at - 1));
  c.at = end + 1;
}

// Moves to the next tag and past it. @return false at the end
bool next_tag(Cursor& c, Tag& tag) {
  for (;;) {
    c.at = std::min(c.text.find('<', c.at), c.text.size());
    if (c.at == c.text.size()) return false;
    if (c.text.substr(c.at, 4) == "<!--")
      skip_past(c, "-->");
    else if (c.text.substr(c.at, 2) == "<?" || c.text.substr(c.at, 2) == "<!")
      skip_past(c, ">");
    else
      break;
  }
  tag = {};
  const std::size_t begin = ++c.at;
  while (c.at < c.text.size() && !is_space(c.text[c.at]) && c.text[c.at] != '>' &&
         (c.text[c.at] != '/' || c.at == begin))
    ++c.at;
  tag.name = c.text.substr(begin, c.at - begin);
  for (;;) {
    skip_spaces(c);
    if (c.at >= c.text.size()) c.fail("the file ends within a tag");
    if (c.text[c.at] == '>') break;
    if (c.text[c.at] == '/') {
      tag.self_closed = true;
      ++c.at;
    } else {
      read_attribute(c, tag);
    }
  }
  ++c.at;
  return true;
}

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  return -1;
}

// Bytes of one array: raw, or base64 decoded on the way. Padding within the base64 text ends a
// part, and the next part follows: VTK encodes the length by itself, other writers together with
// the values.
class ByteSource {
 public:
  ByteSource(std::string_view text, bool base64) : text_(text), base64_(base64) {}

  // An upper bound of the bytes that are left.
  std::size_t bytes_left() const { return base64_ ? text_.size() / 4 * 3 + 3 : text_.size(); }

  // @return fewer than `count` bytes where the text ends
  std::string take(std::size_t count) {
    if (!base64_) {
      std::string bytes(text_.substr(0, count));
      text_.remove_prefix(bytes.size());
      return bytes;
    }
    std::string bytes = std::move(carry_);
    carry_.clear();
    bytes.reserve(std::min(count, bytes_left()) + 3);
    while (bytes.size() < count && decode_quad(bytes)) {
    }
    if (bytes.size() > count) {
      carry_ = bytes.substr(count);
      bytes.resize(count);
    }
    return bytes;
  }

 private:
  bool decode_quad(std::string& bytes) {
    int values[4], filled = 0, padding = 0;
    while (filled < 4 && !text_.empty()) {
      const char c = text_.front();
      if (!is_space(c)) {
        if (c == '=' && filled >= 2)
          ++padding, values[filled++] = 0;
        else if (base64_value(c) >= 0 && padding == 0)
          values[filled++] = base64_value(c);
        else
          return false;
      }
      text_.remove_prefix(1);
    }
    if (filled < 4) return false;
    const int bits = values[0] << 18 | values[1] << 12 | values[2] << 6 | values[3];
    for (int i = 0; i < 3 - padding; ++i) bytes += static_cast<char>(bits >> (16 - 8 * i) & 0xff);
    return true;
  }

  std::string_view text_;
  std::string carry_;
  bool base64_;
};

template <class T>
void append_as_doubles(const std::string& bytes, std::vector<double>& values) {
  values.reserve(values.size() + bytes.size() / sizeof(T));
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    std::uint64_t bits = 0;
    for (std::size_t i = sizeof(T); i-- > 0;)
      bits = bits << 8 | static_cast<unsigned char>(bytes[at + i]);
    unsigned char ordered[8];
    for (std::size_t i = 0; i < 8; ++i)
      ordered[i] = static_cast<unsigned char>(bits >> (8 * i) & 0xff);
    T value;
    std::memcpy(&value, ordered, sizeof value);
    values.push_back(static_cast<double>(value));
  }
}

struct NumberType {
  std::string_view name;
  std::size_t size;
  void (*append)(const std::string&, std::vector<double>&);
};

constexpr NumberType kTypes[] = {
    {"Float64", 8, append_as_doubles<double>},     {"Float32", 4, append_as_doubles<float>},
    {"Int64", 8, append_as_doubles<std::int64_t>}, {"UInt64", 8, append_as_doubles<std::uint64_t>},
    {"Int32", 4, append_as_doubles<std::int32_t>}, {"UInt32", 4, append_as_doubles<std::uint32_t>},
    {"Int16", 2, append_as_doubles<std::int16_t>}, {"UInt16", 2, append_as_doubles<std::uint16_t>},
    {"Int8", 1, append_as_doubles<std::int8_t>},   {"UInt8", 1, append_as_doubles<std::uint8_t>},
};

class VtuReader {
 public:
  VtuReader(std::string_view text, std::string_view file_name) : cursor_{text, file_name} {
    const std::size_t tag_at = text.find("<AppendedData");
    if (tag_at == std::string_view::npos) return;
    Cursor c{text, file_name, tag_at};
    Tag tag;
    next_tag(c, tag);
    appended_base64_ = tag["encoding"] == "base64";
    const std::size_t mark = text.find('_', c.at);
    appended_ = mark == std::string_view::npos ? std::string_view() : text.substr(mark + 1);
    cursor_.text = text.substr(0, tag_at);
  }

  VtuFile read() {
    Tag tag;
    std::string section;
    while (next_tag(cursor_, tag)) {
      if (tag.name == "VTKFile") {
        check_header(tag);
      } else if (tag.name == "DataArray" || tag.name == "Array") {
        if (in_piece_ && !section.empty()) read_array(tag, section);
      } else if (tag.name == "Piece") {
        begin_piece(tag);
      } else if (tag.name == "/Piece") {
        end_piece();
      } else if (tag.name == "PointData" || tag.name == "CellData" || tag.name == "Points" ||
                 tag.name == "Cells") {
        section = tag.self_closed ? "" : tag.name;
      } else if (!section.empty() && tag.name == "/" + section) {
        section.clear();
      }
    }
    if (!header_seen_) cursor_.fail("no <VTKFile> tag");
    if (in_piece_) cursor_.fail("the file ends before </Piece>");
    return finished();
  }

 private:
  void check_header(const Tag& tag) {
    if (tag["type"] != "UnstructuredGrid")
      cursor_.fail("a file of type '" + std::string(tag["type"].substr(0, 40)) + "'",
                   "Save the tetrahedra as an UnstructuredGrid (.vtu)");
    if (tag["byte_order"] == "BigEndian")
      cursor_.fail("a big-endian file", "Save the file as ascii");
    if (!tag["compressor"].empty())
      cursor_.fail("the arrays are compressed",
                   "Save without compression (ParaView: Compressor Type None; meshio: "
                   "compression=None) or as ascii");
    header_bytes_ = tag["header_type"] == "UInt64" ? 8 : 4;
    header_seen_ = true;
  }

  std::int64_t count_of(const Tag& tag, std::string_view key) const {
    const std::optional<std::int64_t> count = parse_integer(tag[key]);
    if (!count || *count < 0 || *count > std::numeric_limits<Index>::max())
      cursor_.fail("no usable " + std::string(key));
    return *count;
  }

  void begin_piece(const Tag& tag) {
    if (!header_seen_) cursor_.fail("a <Piece> outside <VTKFile>");
    if (in_piece_) cursor_.fail("a <Piece> within a <Piece>");
    piece_points_ = count_of(tag, "NumberOfPoints");
    piece_cells_ = count_of(tag, "NumberOfCells");
    in_piece_ = !tag.self_closed;
    piece_coordinates_.clear();
    cells_.clear();
  }

  // Appends the values of one array. `expected` counts values; negative for any number.
  void read_values(const Tag& tag, std::int64_t expected, std::vector<double>& values) {
    const std::string_view format = tag["format"];
    const std::size_t before = values.size();
    if (format == "appended") {
      read_binary(tag, appended_at(tag), appended_base64_, expected, values);
    } else if (tag.self_closed) {
      // nothing inside
    } else {
      const std::size_t end = std::min(cursor_.text.find('<', cursor_.at), cursor_.text.size());
      const std::string_view inside = cursor_.text.substr(cursor_.at, end - cursor_.at);
      if (format == "binary")
        read_binary(tag, inside, true, expected, values);
      else
        read_ascii(inside, values);
      cursor_.at = end;
    }
    if (expected >= 0 && values.size() - before != static_cast<std::size_t>(expected))
      cursor_.fail("array '" + std::string(tag["Name"].substr(0, 40)) + "' has " +
                   std::to_string(values.size() - before) + " values instead of " +
                   std::to_string(expected));
  }

  std::string_view appended_at(const Tag& tag) const {
    const std::optional<std::int64_t> offset = parse_integer(tag["offset"]);
    if (!offset || *offset < 0 || static_cast<std::uint64_t>(*offset) > appended_.size())
      cursor_.fail("array '" + std::string(tag["Name"].substr(0, 40)) +
                   "' lies outside the appended data");
    return appended_.substr(static_cast<std::size_t>(*offset));
  }

  void read_ascii(std::string_view inside, std::vector<double>& values) {
    for (std::size_t at = 0;;) {
      while (at < inside.size() && is_space(inside[at])) ++at;
      if (at == inside.size()) return;
      const std::size_t begin = at;
      while (at < inside.size() && !is_space(inside[at])) ++at;
      const std::string_view word = inside.substr(begin, at - begin);
      std::optional<double> value = parse_double(word);
      if (!value && lower_case(word).find("nan") != std::string::npos) value = std::nan("");
      if (!value)
        cursor_.fail("expected a number, found '" + std::string(word.substr(0, 40)) + "'");
      values.push_back(*value);
    }
  }

  void read_binary(const Tag& tag, std::string_view text, bool base64, std::int64_t expected,
                   std::vector<double>& values) {
    const NumberType* type =
        std::find_if(std::begin(kTypes), std::end(kTypes),
                     [&](const NumberType& t) { return t.name == tag["type"]; });
    if (type == std::end(kTypes))
      cursor_.fail("numbers of type '" + std::string(tag["type"].substr(0, 40)) + "'");
    ByteSource source(text, base64);
    const std::string header = source.take(header_bytes_);
    std::uint64_t size = 0;
    for (std::size_t i = header.size(); i-- > 0;)
      size = size << 8 | static_cast<unsigned char>(header[i]);
    const std::string name(tag["Name"].substr(0, 40));
    if (header.size() < header_bytes_ || size > source.bytes_left())
      cursor_.fail("array '" + name + "' is longer than the file");
    if (expected >= 0 && size != static_cast<std::uint64_t>(expected) * type->size)
      cursor_.fail("array '" + name + "' has " + std::to_string(size) + " bytes instead of " +
                   std::to_string(static_cast<std::uint64_t>(expected) * type->size));
    // Arrays that share their bytes would let a small file ask for any amount of memory.
    bytes_read_ += size;
    if (bytes_read_ > cursor_.text.size() + appended_.size()) cursor_.fail("the arrays overlap");
    const std::string bytes = source.take(static_cast<std::size_t>(size));
    if (bytes.size() < size) cursor_.fail("array '" + name + "' is cut short");
    type->append(bytes, values);
  }

  void read_array(const Tag& tag, const std::string& section) {
    if (tag["type"] == "String") return;
    const std::string name(tag["Name"]);
    if (section == "Points") {
      read_values(tag, 3 * piece_points_, piece_coordinates_);
    } else if (section == "Cells") {
      if (name == "connectivity") read_values(tag, 4 * piece_cells_, cells_[name]);
      if (name == "offsets" || name == "types") read_values(tag, piece_cells_, cells_[name]);
    } else {
      const std::string_view text = tag["NumberOfComponents"];
      const std::optional<std::int64_t> components = text.empty() ? 1 : parse_integer(text);
      if (!components || *components < 1 || *components > 1000)
        cursor_.fail("no usable NumberOfComponents of array '" + name.substr(0, 40) + "'");
      const bool of_points = section == "PointData";
      VtuArray& array = (of_points ? file_.point_data : file_.cell_data)[name];
      if (!array.values.empty() && array.components != *components)
        cursor_.fail("array '" + name.substr(0, 40) + "' changes its number of components");
      array.components = static_cast<int>(*components);
      read_values(tag, *components * (of_points ? piece_points_ : piece_cells_), array.values);
    }
  }

  void end_piece() {
    if (!in_piece_) cursor_.fail("</Piece> without <Piece>");
    in_piece_ = false;
    const auto points = static_cast<std::size_t>(piece_points_),
               cells = static_cast<std::size_t>(piece_cells_);
    if (piece_coordinates_.size() != 3 * points) cursor_.fail("a piece without its points");
    const std::vector<double>&connectivity = cells_["connectivity"], &offsets = cells_["offsets"],
          &types = cells_["types"];
    if (types.size() != cells || connectivity.size() != 4 * cells || offsets.size() != cells)
      cursor_.fail("a piece without its cells' connectivity, offsets or types");
    const std::size_t base = coordinates_.size() / 3;
    for (std::size_t t = 0; t < cells; ++t) {
      if (types[t] != kTetCell)
        cursor_.fail("cell " + std::to_string(t) + " is of VTK type " +
                         std::to_string(std::lround(std::clamp(types[t], -1.0, 255.0))) +
                         ", not a linear tetrahedron (10)",
                     "Export tetrahedra only, without surface or line cells");
      if (offsets[t] != static_cast<double>(4 * (t + 1)))
        cursor_.fail("cell " + std::to_string(t) + " has a wrong offset");
      for (std::size_t i = 0; i < 4; ++i) {
        const double corner = connectivity[4 * t + i];
        if (!(corner >= 0 && corner < static_cast<double>(points)) || corner != std::floor(corner))
          cursor_.fail("cell " + std::to_string(t) + " names a point outside its piece");
        corners_.push_back(static_cast<Index>(base + static_cast<std::size_t>(corner)));
      }
    }
    if (base + points > static_cast<std::size_t>(std::numeric_limits<Index>::max()))
      cursor_.fail("too many points");
    coordinates_.insert(coordinates_.end(), piece_coordinates_.begin(), piece_coordinates_.end());
  }

  VtuFile finished() {
    const auto points = static_cast<Eigen::Index>(coordinates_.size() / 3);
    const auto tets = static_cast<Eigen::Index>(corners_.size() / 4);
    const auto check = [&](const std::map<std::string, VtuArray>& arrays, Eigen::Index rows) {
      for (const auto& [name, array] : arrays)
        if (array.values.size() !=
            static_cast<std::size_t>(rows) * static_cast<std::size_t>(array.components))
          cursor_.fail("array '" + name.substr(0, 40) + "' is missing in a piece, or there twice");
    };
    check(file_.point_data, points);
    check(file_.cell_data, tets);
    file_.vertices = Eigen::Map<const Points>(coordinates_.data(), points, 3);
    if (!file_.vertices.allFinite()) cursor_.fail("a point that is not a number");
    file_.tets = Eigen::Map<const Tets>(corners_.data(), tets, 4);
    return std::move(file_);
  }

  Cursor cursor_;
  std::string_view appended_;
  bool appended_base64_ = false, header_seen_ = false, in_piece_ = false;
  std::size_t header_bytes_ = 4;
  std::uint64_t bytes_read_ = 0;
  std::int64_t piece_points_ = 0, piece_cells_ = 0;
  std::vector<double> piece_coordinates_, coordinates_;
  std::map<std::string, std::vector<double>> cells_;
  std::vector<Index> corners_;
  VtuFile file_;
};

}  // namespace

VtuFile read_vtu(std::span<const std::byte> bytes, std::string_view file_name) {
  return VtuReader(as_text(bytes), file_name).read();
}

}  // namespace s3
