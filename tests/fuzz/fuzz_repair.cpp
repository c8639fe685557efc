// Small surfaces made of the bytes: corners on a coarse grid, so that they often coincide, touch
// and overlap; a few exact doubles among them.
#include <cstring>
#include <vector>

#include "fuzz.h"
#include "mesh/repair.h"

namespace {

using s3::Index;

constexpr std::size_t kMaxVertices = 64, kMaxTriangles = 128;

// Three bytes a vertex; the value 255 takes the next eight bytes as a double, whatever it is.
s3::TriMesh mesh_of(const std::uint8_t* data, std::size_t size) {
  std::size_t at = 0;
  const auto next = [&]() -> std::uint8_t { return at < size ? data[at++] : 0; };
  const std::size_t vertices = 1 + next() % kMaxVertices;
  s3::TriMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices), 3);
  for (Eigen::Index i = 0; i < mesh.vertices.size(); ++i) {
    const std::uint8_t byte = next();
    double value = byte % 16;
    if (byte >= 240) value += 1e-7 * (byte - 240);
    if (byte == 255 && size - at >= sizeof value) {
      std::memcpy(&value, data + at, sizeof value);
      at += sizeof value;
    }
    mesh.vertices.data()[i] = value;
  }
  const std::size_t triangles = std::min(kMaxTriangles, (size - at) / 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles), 3);
  for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i)
    mesh.triangles.data()[i] = static_cast<Index>(next() % vertices);
  return mesh;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    s3::Context ctx;
    const s3::RepairResult result = s3::repair_surface(
        mesh_of(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()), ctx);
    s3::fuzz::require_in_range(result.surface.vertices, result.surface.triangles);
    s3::fuzz::require(result.valid == result.reason.empty());
    s3::fuzz::require(!result.valid || result.report.volume > 0);
    for (const s3::RepairChange& change : result.changes)
      s3::fuzz::require(change.count > 0 && !change.sentence.empty());
  });
}
