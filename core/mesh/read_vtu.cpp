// The format: "VTK File Formats", section "XML File Formats", kitware.com/products/books.
#include "mesh/read_vtu.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "mesh/text_scanner.h"
#include "mesh/xml_reader.h"

namespace s3 {

namespace {

constexpr double kTetCell = 10;  // VTK_TETRA

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
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
  VtuReader(std::string_view text, std::string_view file_name)
      : xml_(text.substr(0, text.find("<AppendedData")), file_name), size_(text.size()) {
    const std::size_t tag_at = text.find("<AppendedData");
    if (tag_at == std::string_view::npos) return;
    const std::string_view rest = text.substr(tag_at);
    XmlReader tag(rest, file_name);
    tag.next();
    appended_base64_ = tag["encoding"] == "base64";
    const std::size_t mark = rest.find('_', tag.position());
    appended_ = mark == std::string_view::npos ? std::string_view() : rest.substr(mark + 1);
  }

  VtuFile read() {
    std::string section;
    while (xml_.next()) {
      const std::string_view name = xml_.name();
      if (xml_.closes()) {
        if (name == "Piece") end_piece();
        if (name == section) section.clear();
      } else if (name == "VTKFile") {
        check_header();
      } else if (name == "DataArray" || name == "Array") {
        if (in_piece_ && !section.empty()) read_array(section);
      } else if (name == "Piece") {
        begin_piece();
      } else if (name == "PointData" || name == "CellData" || name == "Points" || name == "Cells") {
        section = xml_.is_empty() ? "" : name;
      }
    }
    if (!header_seen_) xml_.fail("no <VTKFile> tag");
    if (in_piece_) xml_.fail("the file ends before </Piece>");
    return finished();
  }

 private:
  void check_header() {
    if (xml_["type"] != "UnstructuredGrid")
      xml_.fail("a file of type '" + std::string(xml_["type"].substr(0, 40)) + "'",
                "Save the tetrahedra as an UnstructuredGrid (.vtu)");
    if (xml_["byte_order"] == "BigEndian") xml_.fail("a big-endian file", "Save the file as ascii");
    if (!xml_["compressor"].empty())
      xml_.fail("the arrays are compressed",
                "Save without compression (ParaView: Compressor Type None; meshio: "
                "compression=None) or as ascii");
    header_bytes_ = xml_["header_type"] == "UInt64" ? 8 : 4;
    header_seen_ = true;
  }

  std::int64_t count_of(std::string_view key) const {
    const std::optional<std::int64_t> count = parse_integer(xml_[key]);
    if (!count || *count < 0 || *count > std::numeric_limits<Index>::max())
      xml_.fail("no usable " + std::string(key));
    return *count;
  }

  void begin_piece() {
    if (!header_seen_) xml_.fail("a <Piece> outside <VTKFile>");
    if (in_piece_) xml_.fail("a <Piece> within a <Piece>");
    piece_points_ = count_of("NumberOfPoints");
    piece_cells_ = count_of("NumberOfCells");
    in_piece_ = !xml_.is_empty();
    piece_coordinates_.clear();
    cells_.clear();
  }

  // Appends the values of one array. `expected` counts values; negative for any number.
  void read_values(std::int64_t expected, std::vector<double>& values) {
    const std::string_view format = xml_["format"];
    const std::size_t before = values.size();
    if (format == "appended") {
      read_binary(appended_at(), appended_base64_, expected, values);
    } else if (xml_.is_empty()) {
      // nothing inside
    } else {
      const std::string_view inside = xml_.take_text();
      if (format == "binary")
        read_binary(inside, true, expected, values);
      else
        read_ascii(inside, values);
    }
    if (expected >= 0 && values.size() - before != static_cast<std::size_t>(expected))
      xml_.fail("array '" + std::string(xml_["Name"].substr(0, 40)) + "' has " +
                std::to_string(values.size() - before) + " values instead of " +
                std::to_string(expected));
  }

  std::string_view appended_at() const {
    const std::optional<std::int64_t> offset = parse_integer(xml_["offset"]);
    if (!offset || *offset < 0 || static_cast<std::uint64_t>(*offset) > appended_.size())
      xml_.fail("array '" + std::string(xml_["Name"].substr(0, 40)) +
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
      if (!value) xml_.fail("expected a number, found '" + std::string(word.substr(0, 40)) + "'");
      values.push_back(*value);
    }
  }

  void read_binary(std::string_view text, bool base64, std::int64_t expected,
                   std::vector<double>& values) {
    const NumberType* type =
        std::find_if(std::begin(kTypes), std::end(kTypes),
                     [&](const NumberType& t) { return t.name == xml_["type"]; });
    if (type == std::end(kTypes))
      xml_.fail("numbers of type '" + std::string(xml_["type"].substr(0, 40)) + "'");
    ByteSource source(text, base64);
    const std::string header = source.take(header_bytes_);
    std::uint64_t size = 0;
    for (std::size_t i = header.size(); i-- > 0;)
      size = size << 8 | static_cast<unsigned char>(header[i]);
    const std::string name(xml_["Name"].substr(0, 40));
    if (header.size() < header_bytes_ || size > source.bytes_left())
      xml_.fail("array '" + name + "' is longer than the file");
    if (expected >= 0 && size != static_cast<std::uint64_t>(expected) * type->size)
      xml_.fail("array '" + name + "' has " + std::to_string(size) + " bytes instead of " +
                std::to_string(static_cast<std::uint64_t>(expected) * type->size));
    // Arrays that share their bytes would let a small file ask for any amount of memory.
    bytes_read_ += size;
    if (bytes_read_ > size_) xml_.fail("the arrays overlap");
    const std::string bytes = source.take(static_cast<std::size_t>(size));
    if (bytes.size() < size) xml_.fail("array '" + name + "' is cut short");
    type->append(bytes, values);
  }

  void read_array(const std::string& section) {
    if (xml_["type"] == "String") return;
    const std::string name(xml_["Name"]);
    if (section == "Points") {
      read_values(3 * piece_points_, piece_coordinates_);
    } else if (section == "Cells") {
      if (name == "connectivity") read_values(4 * piece_cells_, cells_[name]);
      if (name == "offsets" || name == "types") read_values(piece_cells_, cells_[name]);
    } else {
      const std::string_view text = xml_["NumberOfComponents"];
      const std::optional<std::int64_t> components = text.empty() ? 1 : parse_integer(text);
      if (!components || *components < 1 || *components > 1000)
        xml_.fail("no usable NumberOfComponents of array '" + name.substr(0, 40) + "'");
      const bool of_points = section == "PointData";
      VtuArray& array = (of_points ? file_.point_data : file_.cell_data)[name];
      if (!array.values.empty() && array.components != *components)
        xml_.fail("array '" + name.substr(0, 40) + "' changes its number of components");
      array.components = static_cast<int>(*components);
      read_values(*components * (of_points ? piece_points_ : piece_cells_), array.values);
    }
  }

  void end_piece() {
    if (!in_piece_) xml_.fail("</Piece> without <Piece>");
    in_piece_ = false;
    const auto points = static_cast<std::size_t>(piece_points_),
               cells = static_cast<std::size_t>(piece_cells_);
    if (piece_coordinates_.size() != 3 * points) xml_.fail("a piece without its points");
    const std::vector<double>&connectivity = cells_["connectivity"], &offsets = cells_["offsets"],
          &types = cells_["types"];
    if (types.size() != cells || connectivity.size() != 4 * cells || offsets.size() != cells)
      xml_.fail("a piece without its cells' connectivity, offsets or types");
    const std::size_t base = coordinates_.size() / 3;
    for (std::size_t t = 0; t < cells; ++t) {
      if (types[t] != kTetCell)
        xml_.fail("cell " + std::to_string(t) + " is of VTK type " +
                      std::to_string(std::lround(std::clamp(types[t], -1.0, 255.0))) +
                      ", not a linear tetrahedron (10)",
                  "Export tetrahedra only, without surface or line cells");
      if (offsets[t] != static_cast<double>(4 * (t + 1)))
        xml_.fail("cell " + std::to_string(t) + " has a wrong offset");
      for (std::size_t i = 0; i < 4; ++i) {
        const double corner = connectivity[4 * t + i];
        if (!(corner >= 0 && corner < static_cast<double>(points)) || corner != std::floor(corner))
          xml_.fail("cell " + std::to_string(t) + " names a point outside its piece");
        corners_.push_back(static_cast<Index>(base + static_cast<std::size_t>(corner)));
      }
    }
    if (base + points > static_cast<std::size_t>(std::numeric_limits<Index>::max()))
      xml_.fail("too many points");
    coordinates_.insert(coordinates_.end(), piece_coordinates_.begin(), piece_coordinates_.end());
  }

  VtuFile finished() {
    const auto points = static_cast<Eigen::Index>(coordinates_.size() / 3);
    const auto tets = static_cast<Eigen::Index>(corners_.size() / 4);
    const auto check = [&](const std::map<std::string, VtuArray>& arrays, Eigen::Index rows) {
      for (const auto& [name, array] : arrays)
        if (array.values.size() !=
            static_cast<std::size_t>(rows) * static_cast<std::size_t>(array.components))
          xml_.fail("array '" + name.substr(0, 40) + "' is missing in a piece, or there twice");
    };
    check(file_.point_data, points);
    check(file_.cell_data, tets);
    file_.vertices = Eigen::Map<const Points>(coordinates_.data(), points, 3);
    if (!file_.vertices.allFinite()) xml_.fail("a point that is not a number");
    file_.tets = Eigen::Map<const Tets>(corners_.data(), tets, 4);
    return std::move(file_);
  }

  XmlReader xml_;
  std::size_t size_;
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
