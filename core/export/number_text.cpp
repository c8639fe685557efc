#include "export/number_text.h"

#include <cmath>

namespace s3 {

void append_integer(std::string& text, std::int64_t value) {
  char digits[24];
  int n = 0;
  std::uint64_t rest =
      value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
  do {
    digits[n++] = static_cast<char>('0' + rest % 10);
    rest /= 10;
  } while (rest > 0);
  if (value < 0) text += '-';
  while (n > 0) text += digits[--n];
}

void append_fixed(std::string& text, double value, int decimals) {
  constexpr double kPower[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
  if (!(std::abs(value) < 1e9)) value = 0;
  const auto scaled = static_cast<std::int64_t>(std::llround(std::abs(value) * kPower[decimals]));
  const auto one = static_cast<std::int64_t>(kPower[decimals]);
  if (value < 0 && scaled > 0) text += '-';
  append_integer(text, scaled / one);
  if (decimals == 0) return;
  text += '.';
  const std::int64_t fraction = scaled % one;
  for (std::int64_t digit = one / 10; digit > 0; digit /= 10)
    text += static_cast<char>('0' + fraction / digit % 10);
}

}  // namespace s3
