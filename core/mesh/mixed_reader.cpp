#include "mesh/mixed_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

template <class T>
T from_bits(std::uint64_t bits) {
  using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  const Bits narrow = static_cast<Bits>(bits);
  T value;
  std::memcpy(&value, &narrow, sizeof value);
  return value;
}

// Two's complement of `size` bytes.
std::int64_t sign_extended(std::uint64_t bits, std::size_t size) {
  const std::size_t unused = 64 - 8 * size;
  return static_cast<std::int64_t>(bits << unused) >> unused;
}

bool is_signed_integer(Number type) {
  return type == Number::int8 || type == Number::int16 || type == Number::int32 ||
         type == Number::int64;
}

}  // namespace

std::string quoted(std::string_view word) {
  std::string text = "'";
  text.append(word.substr(0, 40));
  text += '\'';
  return text;
}

std::size_t size_of(Number type) {
  switch (type) {
    case Number::int8:
    case Number::uint8:
      return 1;
    case Number::int16:
    case Number::uint16:
      return 2;
    case Number::int32:
    case Number::uint32:
    case Number::float32:
      return 4;
    case Number::int64:
    case Number::uint64:
    case Number::float64:
      return 8;
  }
  return 0;
}

MixedReader::MixedReader(std::span<const std::byte> bytes, std::string_view file_name)
    : text_(as_text(bytes)), file_name_(file_name) {}

std::string_view MixedReader::take_line() {
  if (at_end()) fail("the file ends too early");
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  const std::string_view line = text_.substr(at_, end - at_);
  at_ = std::min(end + 1, text_.size());
  return trimmed(line);
}

std::string_view MixedReader::take_word() {
  while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

bool MixedReader::skip_past(std::string_view text) {
  const std::size_t found = text_.find(text, at_);
  if (found == std::string_view::npos) return false;
  at_ = found + text.size();
  return true;
}

std::uint64_t MixedReader::take_bits(std::size_t size, std::string_view what) {
  if (text_.size() - at_ < size) fail("the file ends before " + std::string(what));
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t from = mode == Mode::big_endian ? i : size - 1 - i;
    bits = bits << 8 | static_cast<unsigned char>(text_[at_ + from]);
  }
  at_ += size;
  return bits;
}

double MixedReader::take_double(Number type, std::string_view what) {
  if (mode == Mode::text) {
    const std::string_view word = take_word();
    const std::optional<double> value = parse_double(word);
    if (!value)
      fail("expected " + std::string(what) + ", found '" + std::string(word.substr(0, 40)) + "'");
    return *value;
  }
  if (type != Number::float32 && type != Number::float64)
    return static_cast<double>(take_integer(type, what));
  const std::uint64_t bits = take_bits(size_of(type), what);
  const double value = type == Number::float64 ? from_bits<double>(bits)
                                               : static_cast<double>(from_bits<float>(bits));
  if (!std::isfinite(value)) fail(std::string(what) + " that is not a finite number");
  return value;
}

std::int64_t MixedReader::take_integer(Number type, std::string_view what) {
  if (mode == Mode::text) {
    const std::string_view word = take_word();
    const std::optional<std::int64_t> value = parse_integer(word);
    if (!value)
      fail("expected " + std::string(what) + ", found '" + std::string(word.substr(0, 40)) + "'");
    return *value;
  }
  if (type == Number::float32 || type == Number::float64) {
    const double value = take_double(type, what);
    if (value != std::floor(value) || std::abs(value) > 1e15)
      fail(std::string(what) + " that is no integer");
    return static_cast<std::int64_t>(value);
  }
  const std::uint64_t bits = take_bits(size_of(type), what);
  if (is_signed_integer(type)) return sign_extended(bits, size_of(type));
  if (bits >> 63 != 0) fail(std::string(what) + " of " + std::to_string(bits));
  return static_cast<std::int64_t>(bits);
}

void MixedReader::skip(Number type, std::uint64_t count) {
  require_room(count, size_of(type), "values");
  if (mode != Mode::text) {
    at_ += static_cast<std::size_t>(count) * size_of(type);
    return;
  }
  for (std::uint64_t i = 0; i < count; ++i)
    if (take_word().empty()) fail("the file ends within a list");
}

void MixedReader::require_room(std::uint64_t count, std::uint64_t least_bytes,
                               std::string_view what) const {
  // A text number takes a digit and a blank, which the last one may lack.
  const std::uint64_t each = mode == Mode::text ? 2 : std::max<std::uint64_t>(least_bytes, 1);
  const std::uint64_t left = text_.size() - at_ + (mode == Mode::text ? 1 : 0);
  if (count > left / each)
    fail("the file is too short for " + std::to_string(count) + " " + std::string(what));
}

void MixedReader::fail(const std::string& what) const {
  std::string place;
  if (mode == Mode::text) {
    // A line's end belongs to the line that was read last.
    const std::size_t read = at_ > 0 && text_[at_ - 1] == '\n' ? at_ - 1 : at_;
    const auto line =
        1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(read), '\n');
    place = "line " + std::to_string(line);
  } else {
    place = "byte " + std::to_string(at_);
  }
  throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file",
              std::string(file_name_) + ": " + place + ": " + what,
              "The file is damaged or was cut short; export the model again");
}

}  // namespace s3
