#include "fuzz.h"
#include "mesh/read_mesh.h"
#include "mesh/tet_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    s3::ModelFile model = s3::read_tet(bytes, "fuzz");
    s3::fuzz::require_in_range(model.vertices, model.tets);
    const s3::TetMesh mesh = s3::make_tet_mesh(model.vertices, model.tets);
    s3::fuzz::require_in_range(mesh.vertices, mesh.boundary_faces);
  });
}
