#include "export/stress_csv.h"

#include <span>
#include <string>

#include <doctest/doctest.h>

#include "fea/read_stress.h"

using namespace s3;

TEST_CASE("stress.csv is read back to the last bit, in the order of its file") {
  Context ctx;
  const StressField field = stress_field(Tensors::Random(7, 6) / 3, ctx);
  const std::vector<Index> order = {3, 1, 0, 6, 5, 4, 2};
  const std::string text = write_stress_csv(field, order);
  const StressField back =
      read_stress(std::as_bytes(std::span(text.data(), text.size())), "stress.csv", 7, 0.5);
  for (Index row = 0; row < 7; ++row) {
    const Index t = order[static_cast<std::size_t>(row)];
    CHECK(back.stress.row(row) == field.stress.row(t));
    CHECK(back.principal_value[row] == field.principal_value[t]);
    CHECK(back.principal.row(row) == field.principal.row(t));
  }
  CHECK(back.critical_tets == critical_tets(back.principal_value, 0.5));
}
