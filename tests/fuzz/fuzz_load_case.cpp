#include "base/error.h"
#include "fea/loading.h"
#include "fuzz.h"
#include "grid_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    const s3::TetMesh mesh = s3::test::make_grid(2, 2, 2, {2, 2, 2});
    try {
      const s3::Region region = s3::read_region_file(bytes, "fuzz", s3::Stage::fea);
      s3::fuzz::require(!region.shapes.empty() && !s3::region_tets(mesh, region).empty());
    } catch (const s3::Error&) {  // most inputs are no region file
    }
    const s3::LoadCases file = s3::read_load_cases(bytes, "fuzz");
    s3::fuzz::require(!file.cases.empty());
    s3::Context ctx;
    for (const s3::Loading& loading : s3::apply_load_cases(mesh, file, ctx))
      s3::fuzz::require(loading.force.allFinite() && loading.displacement.allFinite());
  });
}
