// Whatever read_model() takes for a mesh goes on into everything that judges and refines surfaces.
#include "fuzz.h"
#include "mesh/placement.h"
#include "mesh/read_mesh.h"
#include "mesh/refine_surface.h"
#include "mesh/tet_mesh.h"
#include "mesh/validate.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    s3::ModelFile model = s3::read_model(bytes, "fuzz");
    if (model.is_volume) {
      s3::make_tet_mesh(model.vertices, model.tets);
      return;
    }
    s3::TriMesh& mesh = model.surface;
    s3::fuzz::require_in_range(mesh.vertices, mesh.triangles);
    s3::clean_surface(mesh);
    const s3::MeshReport report = s3::inspect_surface(mesh);
    s3::require_valid_surface(report);
    s3::placement(mesh.vertices, mesh.triangles, {.rotate = "auto"});
    const s3::TriMesh fine = s3::refine_surface(mesh, report.box.diagonal() / 8);
    s3::fuzz::require_in_range(fine.vertices, fine.triangles);
  });
}
