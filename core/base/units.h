// The unit system: mm, N, MPa (= N/mm²), s, rad inside the core. Degrees exist only in parameters
// and reports.
#pragma once
#include <numbers>

namespace s3 {

constexpr double kPi = std::numbers::pi;
constexpr double radians(double deg) {
  return deg * kPi / 180.0;
}
constexpr double degrees(double rad) {
  return rad * 180.0 / kPi;
}

}  // namespace s3
