#include "fuzz.h"
#include "mesh/gzip.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    if (s3::is_gzip(bytes)) s3::unpack_gzip(bytes, "fuzz");
  });
}
