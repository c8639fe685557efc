#include "mesh/text_scanner.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "base/error.h"

namespace s3 {

namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// The syntax [+-] digits [. digits] [e [+-] digits], which strtod is wider than (hex, inf, nan).
struct Decimal {
  bool valid = false, negative = false;
  std::uint64_t mantissa = 0;  // first 19 significant digits
  bool truncated = false;      // there were more digits
  int exponent = 0;            // value = mantissa · 10^exponent
};

Decimal scan_decimal(std::string_view s) {
  Decimal d;
  std::size_t i = 0;
  if (i < s.size() && (s[i] == '+' || s[i] == '-')) d.negative = s[i++] == '-';
  int digits = 0, significant = 0;
  for (bool fraction = false; i < s.size(); ++i) {
    if (s[i] == '.' && !fraction) {
      fraction = true;
      continue;
    }
    if (!is_digit(s[i])) break;
    ++digits;
    if (significant < 19) {
      d.mantissa = 10 * d.mantissa + static_cast<std::uint64_t>(s[i] - '0');
      if (d.mantissa != 0) ++significant;
      if (fraction) --d.exponent;
    } else {
      d.truncated = true;
      if (!fraction) ++d.exponent;
    }
  }
  if (digits == 0) return d;
  if (i < s.size() && (s[i] == 'e' || s[i] == 'E')) {
    ++i;
    bool negative = false;
    if (i < s.size() && (s[i] == '+' || s[i] == '-')) negative = s[i++] == '-';
    int exponent = 0, exponent_digits = 0;
    for (; i < s.size() && is_digit(s[i]); ++i, ++exponent_digits)
      if (exponent < 100000) exponent = 10 * exponent + (s[i] - '0');
    if (exponent_digits == 0) return d;
    d.exponent += negative ? -exponent : exponent;
  }
  d.valid = i == s.size();
  return d;
}

// strtod needs a terminated string; numbers longer than any printed double are cut to what decides
// their value.
std::optional<double> slow_double(std::string_view word) {
  char buffer[64];
  std::optional<double> result;
  if (word.size() < sizeof buffer) {
    std::memcpy(buffer, word.data(), word.size());
    buffer[word.size()] = '\0';
    result = std::strtod(buffer, nullptr);
  } else {
    result = std::strtod(std::string(word).c_str(), nullptr);
  }
  return std::isfinite(*result) ? result : std::nullopt;
}

}  // namespace

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string_view trimmed(std::string_view text) {
  const auto is_outer = [](char c) { return is_blank(c) || c == '\n'; };
  while (!text.empty() && is_outer(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_outer(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view take_word(std::string_view& rest) {
  std::size_t begin = 0;
  while (begin < rest.size() && is_blank(rest[begin])) ++begin;
  std::size_t end = begin;
  while (end < rest.size() && !is_blank(rest[end])) ++end;
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

std::optional<double> parse_double(std::string_view word) {
  const Decimal d = scan_decimal(word);
  if (!d.valid) return std::nullopt;
  // Clinger's fast path: an exact mantissa times or divided by an exact power of ten rounds once,
  // hence correctly.
  static constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                       1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                       1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  if (!d.truncated && d.mantissa < (std::uint64_t{1} << 53) && std::abs(d.exponent) <= 22) {
    const double m = static_cast<double>(d.mantissa);
    const double value = d.exponent < 0 ? m / kPowers[-d.exponent] : m * kPowers[d.exponent];
    return d.negative ? -value : value;
  }
  return slow_double(word);
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
  std::size_t i = 0;
  bool negative = false;
  if (!word.empty() && (word[0] == '+' || word[0] == '-')) negative = word[i++] == '-';
  if (i == word.size() || word.size() - i > 18) return std::nullopt;
  std::int64_t value = 0;
  for (; i < word.size(); ++i) {
    if (!is_digit(word[i])) return std::nullopt;
    value = 10 * value + (word[i] - '0');
  }
  return negative ? -value : value;
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

bool LineReader::next(char comment) {
  while (!rest_.empty()) {
    const std::size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++line_number_;
    if (comment != '\0') line_ = line_.substr(0, line_.find(comment));
    line_ = trimmed(line_);
    if (!line_.empty()) return true;
  }
  line_ = {};
  return false;
}

double LineReader::take_double(std::string_view what) {
  const std::string_view word = take_word(line_);
  const std::optional<double> value = parse_double(word);
  if (!value)
    fail("expected " + std::string(what) + ", found '" + std::string(word.substr(0, 40)) + "'");
  return *value;
}

std::int64_t LineReader::take_integer(std::string_view what) {
  const std::string_view word = take_word(line_);
  const std::optional<std::int64_t> value = parse_integer(word);
  if (!value)
    fail("expected " + std::string(what) + ", found '" + std::string(word.substr(0, 40)) + "'");
  return *value;
}

Vec3 LineReader::take_point() {
  Vec3 p;
  for (int k = 0; k < 3; ++k) p[k] = take_double("a coordinate");
  return p;
}

void LineReader::fail(const std::string& what) const {
  throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file",
              std::string(file_name_) + ": line " + std::to_string(line_number_) + ": " + what,
              "The file is damaged or of another kind; export the model again");
}

}  // namespace s3
