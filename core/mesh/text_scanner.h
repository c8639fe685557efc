// Lines, words and numbers from text that may be hostile: no copy of the file, no trust in counts.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/types.h"

namespace s3 {

/// The bytes as text; valid as long as the bytes are.
std::string_view as_text(std::span<const std::byte> bytes);

/// Without blanks and line ends at either end.
std::string_view trimmed(std::string_view text);

/// Takes the next word (separated by blanks and tabs) off the front of `rest`; empty at the end.
std::string_view take_word(std::string_view& rest);
/// A whole word as a number. Reads "1.5", "-2e-3", "+4"; nothing for anything else, for NaN and for
/// infinity.
std::optional<double> parse_double(std::string_view word);
/// A whole word as an integer; nothing when it is not one or does not fit.
std::optional<std::int64_t> parse_integer(std::string_view word);
/// ASCII lower case.
std::string lower_case(std::string_view text);

/// Walks the lines of a text file and knows where it is, so that errors can say "part.obj: line 12:
/// …".
class LineReader {
 public:
  LineReader(std::string_view text, std::string_view file_name)
      : rest_(text), file_name_(file_name) {}

  /// Moves to the next line that holds more than blanks; text after `comment` is cut off.
  /// @return false at the end of the file
  bool next(char comment = '\0');
  /// What is left of the current line.
  std::string_view& line() { return line_; }
  /// Bytes after the current line: the bound for every count in the file.
  std::size_t bytes_left() const { return rest_.size(); }

  /// Takes a finite number, or an integer, off the current line. @throws Error "mesh.bad_file"
  double take_double(std::string_view what);
  std::int64_t take_integer(std::string_view what);
  /// Takes x y z. @throws Error "mesh.bad_file"
  Vec3 take_point();

  /// @throws Error "mesh.bad_file" at the current line
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view rest_, line_, file_name_;
  std::int64_t line_number_ = 0;
};

}  // namespace s3
