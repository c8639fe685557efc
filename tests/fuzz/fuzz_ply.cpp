#include "fuzz.h"
#include "mesh/read_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    const s3::TriMesh mesh = s3::read_ply(bytes, "fuzz");
    s3::fuzz::require_in_range(mesh.vertices, mesh.triangles);
  });
}
