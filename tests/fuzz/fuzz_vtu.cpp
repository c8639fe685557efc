#include "fuzz.h"
#include "mesh/read_vtu.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return s3::fuzz::run(data, size, [](auto bytes) {
    const s3::VtuFile file = s3::read_vtu(bytes, "fuzz");
    s3::fuzz::require_in_range(file.vertices, file.tets);
    const auto has_rows = [](const s3::VtuArray& array, auto rows) {
      s3::fuzz::require(array.values.size() == static_cast<std::size_t>(rows) *
                                                   static_cast<std::size_t>(array.components));
    };
    for (const auto& [name, array] : file.point_data) has_rows(array, file.vertices.rows());
    for (const auto& [name, array] : file.cell_data) has_rows(array, file.tets.rows());
  });
}
