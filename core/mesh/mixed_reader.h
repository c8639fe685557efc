// Numbers from bytes that hold text, binary values or both, as PLY and Gmsh files do.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace s3 {

/// The types that binary files store numbers in.
enum class Number : std::uint8_t {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};

std::size_t size_of(Number type);

/// The word in quotes, cut to a length that suits a message.
std::string quoted(std::string_view word);

/// Walks a file that begins as text; the rest may be text too, or binary of either byte order.
/// Errors say where: "part.ply: line 12: …" or "part.ply: byte 1234: …".
class MixedReader {
 public:
  enum class Mode : std::uint8_t { text, little_endian, big_endian };

  MixedReader(std::span<const std::byte> bytes, std::string_view file_name);

  /// How numbers are written from here on.
  Mode mode = Mode::text;

  /// The rest of the current line without its end and outer blanks, in any mode.
  /// @throws Error "mesh.bad_file" at the end of the file
  std::string_view take_line();
  /// The next word on this line or a later one; empty at the end of the file.
  std::string_view take_word();
  /// Moves past the next appearance of `text`. @return false (and stays) where there is none
  bool skip_past(std::string_view text);

  /// The next number: in text any number, in binary one of `type`.
  /// @throws Error "mesh.bad_file" when there is none, or it is NaN or infinite, or no integer
  double take_double(Number type, std::string_view what);
  std::int64_t take_integer(Number type, std::string_view what);
  /// Moves past `count` numbers without looking at them. @throws Error "mesh.bad_file"
  void skip(Number type, std::uint64_t count);

  /// The bound of every count in the file.
  /// @param least_bytes  what one of them takes at least in binary (a text number takes two)
  /// @throws Error "mesh.bad_file" when the rest of the file cannot hold so many
  void require_room(std::uint64_t count, std::uint64_t least_bytes, std::string_view what) const;

  bool at_end() const { return at_ == text_.size(); }
  /// @throws Error "mesh.bad_file" at the current line or byte
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::uint64_t take_bits(std::size_t size, std::string_view what);

  std::string_view text_, file_name_;
  std::size_t at_ = 0;
};

}  // namespace s3
