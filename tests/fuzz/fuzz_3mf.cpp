// The archive. The check sums in it keep a fuzzer from what is inside: that is fuzz_3mf_xml.
#include "fuzz.h"
#include "mesh/read_3mf.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    const s3::ModelFile model = s3::read_3mf(bytes, "fuzz");
    s3::fuzz::require_in_range(model.surface.vertices, model.surface.triangles);
  });
}
