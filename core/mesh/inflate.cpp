// DEFLATE: RFC 1951. CRC-32: RFC 1952, section 8.
#include "mesh/inflate.h"

#include <algorithm>
#include <array>

namespace s3 {

namespace {

// Bits, the lowest of each byte first. Behind the end there are zeros, which `overrun` tells.
class BitReader {
 public:
  explicit BitReader(std::string_view bytes) : bytes_(bytes) {}

  std::uint32_t peek(int count) {
    refill();
    return static_cast<std::uint32_t>(buffer_ & ((std::uint64_t{1} << count) - 1));
  }
  void drop(int count) {
    buffer_ >>= count;
    held_ -= count;
  }
  std::uint32_t take(int count) {
    const std::uint32_t bits = peek(count);
    drop(count);
    return bits;
  }
  bool overrun() const { return held_ < 0; }

  // Bytes from the next whole one on. @return fewer than `count` at the end
  std::string_view take_bytes(std::size_t count) {
    refill();
    at_ -= static_cast<std::size_t>(std::max(held_, 0)) / 8;
    buffer_ = 0;
    held_ = 0;
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += taken.size();
    return taken;
  }

 private:
  void refill() {
    for (; held_ >= 0 && held_ <= 48 && at_ < bytes_.size(); held_ += 8)
      buffer_ |= std::uint64_t{static_cast<unsigned char>(bytes_[at_++])} << held_;
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::uint64_t buffer_ = 0;
  int held_ = 0;  // bits in the buffer; negative after more was dropped than there was
};

// A canonical prefix code: a table for the short words, counts for the long ones.
class PrefixCode {
 public:
  // @return false when there are more words than the lengths have room for
  bool build(const std::uint8_t* lengths, int symbols) {
    counts_.fill(0);
    fast_.fill({});
    for (int s = 0; s < symbols; ++s) ++counts_[lengths[s]];
    counts_[0] = 0;
    std::array<int, kLongest + 2> first_index{};
    std::array<std::uint32_t, kLongest + 2> next_word{};
    int room = 1;
    for (int length = 1; length <= kLongest; ++length) {
      room = 2 * room - counts_[length];
      if (room < 0) return false;
      first_index[length + 1] = first_index[length] + counts_[length];
      next_word[length + 1] = (next_word[length] + static_cast<std::uint32_t>(counts_[length]))
                              << 1;
    }
    for (int s = 0; s < symbols; ++s)
      if (const int length = lengths[s]; length != 0) {
        symbols_[first_index[length]++] = static_cast<std::uint16_t>(s);
        fill_fast(next_word[length]++, length, static_cast<std::uint16_t>(s));
      }
    return true;
  }

  // @return −1 for a word that is not in the code
  int take(BitReader& bits) const {
    const std::uint32_t ahead = bits.peek(kLongest);
    const Entry entry = fast_[ahead & (kFastSize - 1)];
    if (entry.length != 0) {
      bits.drop(entry.length);
      return entry.symbol;
    }
    int word = 0, first = 0, index = 0;
    for (int length = 1; length <= kLongest; ++length) {
      word |= static_cast<int>(ahead >> (length - 1) & 1);
      if (word - counts_[length] < first) {
        bits.drop(length);
        return symbols_[index + word - first];
      }
      index += counts_[length];
      first = (first + counts_[length]) << 1;
      word <<= 1;
    }
    return -1;
  }

 private:
  static constexpr int kLongest = 15, kFastBits = 10, kMostSymbols = 288;
  static constexpr std::size_t kFastSize = 1 << kFastBits;

  struct Entry {
    std::uint16_t symbol = 0;
    std::uint8_t length = 0;  // 0: the word is longer
  };

  // Words are sent from their highest bit on.
  void fill_fast(std::uint32_t word, int length, std::uint16_t symbol) {
    if (length > kFastBits) return;
    std::uint32_t reversed = 0;
    for (int i = 0; i < length; ++i) reversed |= (word >> i & 1) << (length - 1 - i);
    for (std::size_t at = reversed; at < kFastSize; at += std::size_t{1} << length)
      fast_[at] = {symbol, static_cast<std::uint8_t>(length)};
  }

  std::array<int, kLongest + 1> counts_{};
  std::array<std::uint16_t, kMostSymbols> symbols_{};
  std::array<Entry, kFastSize> fast_{};
};

class Inflater {
 public:
  Inflater(std::string_view packed, std::size_t size) : bits_(packed), size_(size) {
    out_.reserve(size);
  }

  std::optional<std::string> run() {
    for (bool last = false; !last;) {
      last = bits_.take(1) == 1;
      const std::uint32_t kind = bits_.take(2);
      const bool good = kind == 0   ? copy_stored()
                        : kind == 1 ? set_fixed_codes() && unpack()
                        : kind == 2 ? take_codes() && unpack()
                                    : false;
      if (!good || bits_.overrun()) return std::nullopt;
    }
    if (out_.size() != size_) return std::nullopt;
    return std::move(out_);
  }

 private:
  bool copy_stored() {
    const std::string_view header = bits_.take_bytes(4);
    if (header.size() < 4) return false;
    const auto byte = [&](int i) {
      return static_cast<unsigned char>(header[static_cast<std::size_t>(i)]);
    };
    const std::size_t length = byte(0) | byte(1) << 8, inverse = byte(2) | byte(3) << 8;
    if (length != (~inverse & 0xffff) || length > size_ - out_.size()) return false;
    const std::string_view stored = bits_.take_bytes(length);
    out_ += stored;
    return stored.size() == length;
  }

  bool set_fixed_codes() {
    std::array<std::uint8_t, 288> lengths;
    for (int s = 0; s < 288; ++s)
      lengths[static_cast<std::size_t>(s)] = s < 144 ? 8 : s < 256 ? 9 : s < 280 ? 7 : 8;
    std::array<std::uint8_t, 30> distance_lengths;
    distance_lengths.fill(5);
    return literals_.build(lengths.data(), 288) && distances_.build(distance_lengths.data(), 30);
  }

  bool take_codes() {
    static constexpr std::uint8_t kOrder[19] = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                11, 4,  12, 3, 13, 2, 14, 1, 15};
    const int literals = static_cast<int>(bits_.take(5)) + 257;
    const int distances = static_cast<int>(bits_.take(5)) + 1;
    const int sent = static_cast<int>(bits_.take(4)) + 4;
    if (literals > 286 || distances > 30) return false;
    std::uint8_t code_lengths[19] = {};
    for (int i = 0; i < sent; ++i)
      code_lengths[kOrder[i]] = static_cast<std::uint8_t>(bits_.take(3));
    PrefixCode code;
    if (!code.build(code_lengths, 19)) return false;

    std::uint8_t lengths[286 + 30] = {};
    for (int at = 0; at < literals + distances;) {
      const int symbol = code.take(bits_);
      if (symbol < 0 || bits_.overrun()) return false;
      if (symbol < 16) {
        lengths[at++] = static_cast<std::uint8_t>(symbol);
        continue;
      }
      if (symbol == 16 && at == 0) return false;
      const std::uint8_t repeated = symbol == 16 ? lengths[at - 1] : std::uint8_t{0};
      const int times = symbol == 16   ? 3 + static_cast<int>(bits_.take(2))
                        : symbol == 17 ? 3 + static_cast<int>(bits_.take(3))
                                       : 11 + static_cast<int>(bits_.take(7));
      if (times > literals + distances - at) return false;
      for (int i = 0; i < times; ++i) lengths[at++] = repeated;
    }
    return lengths[256] != 0 && literals_.build(lengths, literals) &&
           distances_.build(lengths + literals, distances);
  }

  // Literals and copies up to the end of the block.
  bool unpack() {
    for (;;) {
      const int symbol = literals_.take(bits_);
      if (symbol < 0 || bits_.overrun()) return false;
      if (symbol == 256) return true;
      if (symbol < 256) {
        if (out_.size() == size_) return false;
        out_ += static_cast<char>(symbol);
      } else if (!copy(symbol - 257)) {
        return false;
      }
    }
  }

  bool copy(int length_symbol) {
    static constexpr std::uint16_t kLengths[29] = {3,  4,  5,  6,   7,   8,   9,   10,  11, 13,
                                                   15, 17, 19, 23,  27,  31,  35,  43,  51, 59,
                                                   67, 83, 99, 115, 131, 163, 195, 227, 258};
    static constexpr std::uint8_t kLengthBits[29] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                                     2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
    static constexpr std::uint16_t kDistances[30] = {
        1,   2,   3,   4,   5,   7,    9,    13,   17,   25,   33,   49,   65,    97,    129,
        193, 257, 385, 513, 769, 1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
    if (length_symbol >= 29) return false;
    const std::size_t length = kLengths[length_symbol] + bits_.take(kLengthBits[length_symbol]);
    const int symbol = distances_.take(bits_);
    if (symbol < 0 || symbol >= 30) return false;
    const std::size_t distance = kDistances[symbol] + bits_.take(symbol < 2 ? 0 : symbol / 2 - 1);
    if (distance > out_.size() || length > size_ - out_.size()) return false;
    // The copy may run into what it makes itself.
    for (std::size_t i = 0; i < length; ++i) out_ += out_[out_.size() - distance];
    return true;
  }

  BitReader bits_;
  std::size_t size_;
  std::string out_;
  PrefixCode literals_, distances_;
};

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = value >> 1 ^ (value & 1 ? 0xedb88320u : 0u);
    table[i] = value;
  }
  return table;
}

}  // namespace

std::optional<std::string> inflate(std::string_view packed, std::size_t size) {
  return Inflater(packed, size).run();
}

std::uint32_t crc32(std::string_view bytes) {
  static constexpr std::array<std::uint32_t, 256> kTable = crc_table();
  std::uint32_t value = 0xffffffffu;
  for (const char c : bytes)
    value = value >> 8 ^ kTable[(value ^ static_cast<unsigned char>(c)) & 0xff];
  return ~value;
}

bool is_plausible_size(std::uint64_t size, std::uint64_t packed) {
  constexpr std::uint64_t kAlwaysFine = 16 << 20, kMostGrowth = 200;
  return size <= std::max(kAlwaysFine, kMostGrowth * packed);
}

}  // namespace s3
