#include "export/stress_csv.h"

#include <array>
#include <cstdio>

namespace s3 {

std::string write_stress_csv(const StressField& field, const std::vector<Index>& order) {
  std::string text = "index,maxPrincipal,S11,S22,S33,S12,S13,S23\n";
  for (Eigen::Index i = 0; i < field.stress.rows(); ++i) {
    const Eigen::Index t = order.empty() ? i : order[static_cast<std::size_t>(i)];
    const auto s = field.stress.row(t);
    std::array<char, 256> row;
    std::snprintf(row.data(), row.size(), "%d,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n",
                  static_cast<int>(i + 1), field.principal_value[t], s[0], s[1], s[2], s[5], s[4],
                  s[3]);
    text += row.data();
  }
  return text;
}

}  // namespace s3
