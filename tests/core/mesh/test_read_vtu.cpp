#include "mesh/read_vtu.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "base/error.h"
#include "mesh/read_mesh.h"

using namespace s3;

namespace {

enum class Encoding { ascii, base64_joined, base64_parts, appended_raw, appended_base64 };

std::string base64(const std::string& bytes) {
  static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](std::size_t k) {
      return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0u;
    };
    const unsigned bits = at(i) << 16 | at(i + 1) << 8 | at(i + 2);
    for (int k = 0; k < 4; ++k) text += digits[bits >> (18 - 6 * k) & 63];
    for (std::size_t k = bytes.size(); k < i + 3; ++k)
      text[text.size() - (k - bytes.size()) - 1] = '=';
  }
  return text;
}

template <class T>
std::string raw(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

template <class T>
struct TypeName;
template <>
struct TypeName<double> {
  static constexpr const char* value = "Float64";
};
template <>
struct TypeName<float> {
  static constexpr const char* value = "Float32";
};
template <>
struct TypeName<std::int64_t> {
  static constexpr const char* value = "Int64";
};
template <>
struct TypeName<std::int32_t> {
  static constexpr const char* value = "Int32";
};
template <>
struct TypeName<std::uint8_t> {
  static constexpr const char* value = "UInt8";
};

class VtuText {
 public:
  VtuText(Encoding encoding, bool long_header) : encoding_(encoding), long_header_(long_header) {}

  template <class T>
  std::string array(const std::string& name, int components, const std::vector<T>& values) {
    std::string tag = "<DataArray type=\"" + std::string(TypeName<T>::value) + "\" Name=\"" + name +
                      "\" NumberOfComponents=\"" + std::to_string(components) + "\"";
    const std::string bytes = raw(values);
    const std::string header =
        long_header_ ? raw(std::vector<std::uint64_t>{bytes.size()})
                     : raw(std::vector<std::uint32_t>{static_cast<std::uint32_t>(bytes.size())});
    switch (encoding_) {
      case Encoding::ascii: {
        tag += " format=\"ascii\">\n";
        for (const T value : values) {
          char word[40];
          std::snprintf(word, sizeof word, "%.17g ", static_cast<double>(value));
          tag += word;
        }
        break;
      }
      case Encoding::base64_joined:
        tag += " format=\"binary\">\n  " + base64(header + bytes);
        break;
      case Encoding::base64_parts:
        tag += " format=\"binary\">\n" + base64(header) + base64(bytes);
        break;
      case Encoding::appended_raw:
      case Encoding::appended_base64:
        tag += " format=\"appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
        appended_ +=
            encoding_ == Encoding::appended_raw ? header + bytes : base64(header) + base64(bytes);
        return tag;
    }
    return tag + "\n</DataArray>\n";
  }

  std::string file(const std::string& pieces) const {
    std::string text =
        "<?xml version=\"1.0\"?>\n<!-- <Piece> in a comment -->\n<VTKFile "
        "type=\"UnstructuredGrid\" version=\"1.0\" "
        "byte_order=\"LittleEndian\" header_type=\"" +
        std::string(long_header_ ? "UInt64" : "UInt32") + "\">\n<UnstructuredGrid>\n" + pieces +
        "</UnstructuredGrid>\n";
    if (encoding_ == Encoding::appended_raw)
      text += "<AppendedData encoding=\"raw\">\n _" + appended_ + "\n</AppendedData>\n";
    if (encoding_ == Encoding::appended_base64)
      text += "<AppendedData encoding=\"base64\">\n _" + appended_ + "\n</AppendedData>\n";
    return text + "</VTKFile>\n";
  }

 private:
  Encoding encoding_;
  bool long_header_;
  std::string appended_;
};

// Two tets on five points with a field at the points and two at the tets.
std::string piece(VtuText& vtu, double shift = 0) {
  std::string text = "<Piece NumberOfPoints=\"5\" NumberOfCells=\"2\">\n<PointData Scalars='G'>\n";
  text += vtu.array<float>("G", 1, {0.5f, 1, 2, 3, -4});
  text += "</PointData>\n<CellData>\n";
  text += vtu.array<double>("lpd", 3, {0, 0, 1, 0.6, 0, 0.8});
  text += vtu.array<std::uint8_t>("critical", 1, {0, 1});
  text += "</CellData>\n<Points>\n";
  text += vtu.array<double>("Points", 3, {shift, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1.0 / 3, 1, 1});
  text += "</Points>\n<Cells>\n";
  text += vtu.array<std::int64_t>("connectivity", 1, {0, 1, 2, 3, 1, 2, 3, 4});
  text += vtu.array<std::int32_t>("offsets", 1, {4, 8});
  text += vtu.array<std::uint8_t>("types", 1, {10, 10});
  return text + "</Cells>\n</Piece>\n";
}

VtuFile read(const std::string& text) {
  return read_vtu({reinterpret_cast<const std::byte*>(text.data()), text.size()}, "a.vtu");
}

std::string error_of(const std::string& text) {
  try {
    read(text);
  } catch (const Error& e) {
    CHECK(e.code == "mesh.bad_file");
    return std::string(e.what()) + " | " + e.hint;
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  REQUIRE(text.find(from) != std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("a VTU file reads the same in every encoding") {
  for (const Encoding encoding : {Encoding::ascii, Encoding::base64_joined, Encoding::base64_parts,
                                  Encoding::appended_raw, Encoding::appended_base64})
    for (const bool long_header : {false, true}) {
      CAPTURE(static_cast<int>(encoding));
      CAPTURE(long_header);
      VtuText vtu(encoding, long_header);
      const std::string text = vtu.file(piece(vtu));
      const VtuFile file = read(text);
      REQUIRE(file.vertices.rows() == 5);
      CHECK(file.vertices(4, 0) == 1.0 / 3);
      REQUIRE(file.tets.rows() == 2);
      CHECK(file.tets.row(1) == Tets::RowXpr::PlainObject(1, 2, 3, 4));
      REQUIRE(file.point_data.count("G") == 1);
      CHECK(file.point_data.at("G").values == std::vector<double>{0.5, 1, 2, 3, -4});
      CHECK(file.cell_data.at("lpd").components == 3);
      CHECK(file.cell_data.at("lpd").values == std::vector<double>{0, 0, 1, 0.6, 0, 0.8});
      CHECK(file.cell_data.at("critical").values == std::vector<double>{0, 1});
      const ModelFile model =
          read_model({reinterpret_cast<const std::byte*>(text.data()), text.size()}, "x");
      CHECK(model.format == "vtu");
      CHECK(model.is_volume);
      CHECK(model.tets.rows() == 2);
    }
}

TEST_CASE("pieces are joined") {
  VtuText vtu(Encoding::base64_joined, true);
  const std::string first = piece(vtu), second = piece(vtu, 7);
  const VtuFile file = read(vtu.file(first + second));
  CHECK(file.vertices.rows() == 10);
  CHECK(file.vertices(5, 0) == 7);
  CHECK(file.tets.row(2) == Tets::RowXpr::PlainObject(5, 6, 7, 8));
  CHECK(file.cell_data.at("lpd").values.size() == 12);
}

TEST_CASE("VTU errors say what to do") {
  VtuText vtu(Encoding::ascii, false);
  const std::string good = vtu.file(piece(vtu));
  CHECK(error_of(good) == "no error");
  CHECK(error_of(replaced(good, "byte_order", "compressor=\"vtkZLibDataCompressor\" byte_order"))
            .find("Save without compression") != std::string::npos);
  CHECK(error_of(replaced(good, "LittleEndian", "BigEndian")).find("big-endian") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "\"UnstructuredGrid\"", "\"PolyData\"")).find("UnstructuredGrid") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "10 10", "10 12")).find("cell 1 is of VTK type 12") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "10 10", "10 1e99")).find("cell 1 is of VTK type") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "NumberOfPoints=\"5\"", "NumberOfPoints=\"4294967295\""))
            .find("NumberOfPoints") != std::string::npos);
  CHECK(error_of(replaced(good, "NumberOfPoints=\"5\"", "NumberOfPoints=\"2000000000\""))
            .find("instead of") != std::string::npos);
  CHECK(error_of(replaced(good, "0 1 2 3 1 2 3 4", "0 1 2 3 1 2 3 5")).find("outside") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "0 1 2 3 1 2 3 4", "0 1 2 3 1 2 3 0.5")).find("outside") !=
        std::string::npos);
  CHECK(error_of(replaced(good, "0 1 2 3 1 2 3 4", "0 1 2 3 1 2 3 x")).find("line ") !=
        std::string::npos);
}

TEST_CASE("arrays of a small VTU file that share their bytes cannot fill the memory") {
  VtuText vtu(Encoding::appended_raw, false);
  const std::string one = vtu.array<double>("a", 1, std::vector<double>(1000, 1.0));
  std::string many;
  for (int i = 0; i < 500; ++i)
    many += replaced(one, "Name=\"a\"", "Name=\"" + std::to_string(i) + "\"");
  const std::string head = "<Piece NumberOfPoints=\"1000\" NumberOfCells=\"0\"><PointData>";
  CHECK(error_of(vtu.file(head + many + "</PointData></Piece>")).find("the arrays overlap") !=
        std::string::npos);
}

TEST_CASE("a VTU file cut or damaged anywhere gives an error or a mesh in range") {
  for (const Encoding encoding : {Encoding::ascii, Encoding::base64_joined, Encoding::appended_raw,
                                  Encoding::appended_base64}) {
    VtuText vtu(encoding, encoding != Encoding::ascii);
    const std::string good = vtu.file(piece(vtu));
    const auto check = [](const std::string& text) {
      try {
        const VtuFile file = read(text);
        CHECK(file.vertices.allFinite());
        if (file.tets.size() > 0) {
          CHECK(file.tets.minCoeff() >= 0);
          CHECK(file.tets.maxCoeff() < file.vertices.rows());
        }
      } catch (const Error& e) {
        CHECK(e.kind == ErrorKind::input);
      }
    };
    for (std::size_t size = 0; size < good.size(); size += 3) check(good.substr(0, size));
    for (std::size_t bit = 0; bit < 8 * good.size(); bit += 7) {
      std::string damaged = good;
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
      check(damaged);
    }
  }
}
