#include "fuzz.h"
#include "mesh/read_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    const s3::ModelFile model = s3::read_msh(bytes, "fuzz");
    s3::fuzz::require_in_range(model.vertices, model.tets);
    s3::fuzz::require_in_range(model.surface.vertices, model.surface.triangles);
  });
}
