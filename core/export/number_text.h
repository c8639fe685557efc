// Numbers as text with a fixed count of decimals: fast, locale-free and the same on every platform.
#pragma once
#include <cstdint>
#include <string>

namespace s3 {

/// Appends `value` rounded to `decimals` (0 to 9) digits behind the point, trailing zeros kept; "0"
/// for what is not finite or too large to be a length (|value| ≥ 1e9).
void append_fixed(std::string& text, double value, int decimals);
void append_integer(std::string& text, std::int64_t value);

}  // namespace s3
