#include "export/layers_ply.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "base/error.h"

namespace s3 {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little endian");

constexpr char kProperties[] =
    "property double x\nproperty double y\nproperty double z\n"
    "property double nx\nproperty double ny\nproperty double nz\nproperty double thickness\n";
constexpr char kFaces[] = "property list uchar int vertex_indices\nend_header\n";
constexpr std::size_t kVertexBytes = 7 * sizeof(double);
constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::int32_t);

template <class T>
void append_bytes(std::string& out, const T* values, std::size_t count) {
  out.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

/// Takes the header apart, text by text; the data follows it.
class HeaderReader {
 public:
  HeaderReader(std::string_view text, std::string_view file_name)
      : text_(text), file_name_(file_name) {}

  [[noreturn]] void fail(const char* what) const {
    throw Error(ErrorKind::input, Stage::exporting, "export.bad_file",
                std::string(file_name_) + " is not a layer file: " + what,
                "only files of `s3slice run` are read");
  }
  void expect(std::string_view expected) {
    if (text_.substr(at_, expected.size()) != expected) fail("its header is different");
    at_ += expected.size();
  }
  double number() {
    const std::size_t length = text_.substr(at_).find_first_of(" \n");
    constexpr std::size_t kLongest = 40;
    if (length == std::string_view::npos || length == 0 || length > kLongest)
      fail("a number is missing");
    const std::string digits(text_.substr(at_, length));
    char* end = nullptr;
    const double value = std::strtod(digits.c_str(), &end);
    if (end != digits.c_str() + digits.size() || !std::isfinite(value)) fail("a number is wrong");
    at_ += length;
    return value;
  }
  Index count() {
    const double value = number();
    if (!(value >= 0 && value < 2147483647.0) || value != std::floor(value))
      fail("a count is wrong");
    return static_cast<Index>(value);
  }
  std::size_t position() const { return at_; }

 private:
  std::string_view text_, file_name_;
  std::size_t at_ = 0;
};

}  // namespace

std::string write_layer_ply(const Layer& layer) {
  char comment[96];
  std::snprintf(comment, sizeof comment, "comment layer %d iso_value %.17g partial %d\n",
                layer.layer, layer.iso_value, layer.partial ? 1 : 0);
  const auto vertices = layer.surface.vertices.rows();
  const auto faces = layer.surface.triangles.rows();
  std::string out = "ply\nformat binary_little_endian 1.0\n";
  out += comment;
  out += "element vertex " + std::to_string(vertices) + "\n" + kProperties;
  out += "element face " + std::to_string(faces) + "\n" + kFaces;
  out.reserve(out.size() + static_cast<std::size_t>(vertices) * kVertexBytes +
              static_cast<std::size_t>(faces) * kFaceBytes);
  for (Eigen::Index v = 0; v < vertices; ++v) {
    append_bytes(out, layer.surface.vertices.row(v).data(), 3);
    append_bytes(out, layer.normal.row(v).data(), 3);
    append_bytes(out, &layer.thickness(v), 1);
  }
  for (Eigen::Index f = 0; f < faces; ++f) {
    out += '\3';
    append_bytes(out, layer.surface.triangles.row(f).data(), 3);
  }
  return out;
}

Layer read_layer_ply(std::span<const std::byte> bytes, std::string_view file_name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  HeaderReader header(text, file_name);
  Layer layer;
  header.expect("ply\nformat binary_little_endian 1.0\ncomment layer ");
  layer.layer = header.count();
  header.expect(" iso_value ");
  layer.iso_value = header.number();
  header.expect(" partial ");
  layer.partial = header.count() != 0;
  header.expect("\nelement vertex ");
  const Index vertices = header.count();
  header.expect("\n");
  header.expect(kProperties);
  header.expect("element face ");
  const Index faces = header.count();
  header.expect("\n");
  header.expect(kFaces);

  const std::size_t size = static_cast<std::size_t>(vertices) * kVertexBytes +
                           static_cast<std::size_t>(faces) * kFaceBytes;
  if (bytes.size() - header.position() != size) header.fail("its length does not fit its counts");
  const char* data = text.data() + header.position();
  const auto take = [&](auto* values, std::size_t count) {
    std::memcpy(values, data, count * sizeof(*values));
    data += count * sizeof(*values);
  };
  layer.surface.vertices.resize(vertices, 3);
  layer.normal.resize(vertices, 3);
  layer.thickness.resize(vertices);
  layer.surface.triangles.resize(faces, 3);
  for (Index v = 0; v < vertices; ++v) {
    take(layer.surface.vertices.row(v).data(), 3);
    take(layer.normal.row(v).data(), 3);
    take(&layer.thickness(v), 1);
  }
  for (Index f = 0; f < faces; ++f) {
    if (*data++ != '\3') header.fail("a face is no triangle");
    take(layer.surface.triangles.row(f).data(), 3);
    const auto triangle = layer.surface.triangles.row(f);
    if (triangle.minCoeff() < 0 || triangle.maxCoeff() >= vertices)
      header.fail("a face names a vertex that is not there");
  }
  return layer;
}

std::string layer_file_name(std::size_t position) {
  char name[40];
  std::snprintf(name, sizeof name, "layers/%04zu.ply", position);
  return name;
}

}  // namespace s3
