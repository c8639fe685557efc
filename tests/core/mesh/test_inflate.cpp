#include "mesh/inflate.h"

#include <doctest/doctest.h>

#include <string>

using namespace s3;

namespace {

std::string from_hex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return bytes;
}

std::string numbers() {
  std::string text = "0";
  for (int i = 1; i < 120; ++i) text.append(1, ' ').append(std::to_string(i * i * 7919 % 1000));
  return text;
}

// What zlib 1.2.13 makes of numbers(): once with its own codes, once with the fixed ones.
const std::string kOwnCodes = from_hex(
    "2d91d91103310c425b51092bebb0e9bfb13cc5fec878a40002f633b9ac77dbda6efb4bd32e3b69e176bc2d43"
    "a6ef33972ca259bbf94adba056a7956055f34305dcdab2ad362fb7486406c72be6647ff8df470ffcd0a0473f"
    "b934f719d9ca12d0e1b8636261c6cfb5d658c469e0b8705ec08257ccc9febc04027ea015f4b86a856ac7d0dc"
    "d68be0dc0e3c245ea2aeb5c6a26664fd1238ef6676cd959bb48007340dfd4510b2427e4f53bacdad39ff6f92"
    "b32f44e1f24cdf1485f98f44a2bae6b6437a1f01700f0972bfcfa0119d86a6a89781db8e071f2fa51f");
const std::string kFixedCodes = from_hex(
    "3350b034b454303337533032375430373051b0343755b03051303654b03034533031b654b034305030b4b454"
    "303636030a1b2a181a992898035519999928985a0275999a0131d014a03a23734b05734b3305435343056313"
    "a031207540da12c837018a5b00e50d41e601d583b401b51b9b418d33513034047181a2960a2640451640cb0d"
    "818e30023ac6d002e23433a013812e3506bad814e87253a03263206d09e49b00c52da03eb0042ab7006a3305"
    "6a378698660a34d5cc18a4cd50c108ea0543a0ddc640379800dd626c0a719a19d08996202e5018ea0343206d"
    "0ee41b5a826c81f8d414a8dc18a8cd12a41dea054ba0b19640e3cd4121650909392390f5e090045a0bf58429"
    "d09516a0f0060614d0f106401f590283ce0c68b72150133412808acd409a809acda0d1600932141442a08082"
    "fa0168b721d00d8620b7985a0200");
// 1000 times "a", then 1000 times "ab"; and stored bytes.
const std::string kRepeated = from_hex("edc1010d00000c02a0acda3f8439fe0109f05e55d5eb07");
const std::string kStored = from_hex("010c00f3ff73746f726564206279746573");

}  // namespace

TEST_CASE("streams of zlib unpack to what was packed") {
  CHECK(inflate(kOwnCodes, numbers().size()) == numbers());
  CHECK(inflate(kFixedCodes, numbers().size()) == numbers());
  CHECK(inflate(kStored, 12) == "stored bytes");
  std::string repeated(1000, 'a');
  for (int i = 0; i < 1000; ++i) repeated += "ab";
  CHECK(inflate(kRepeated, repeated.size()) == repeated);
}

TEST_CASE("a stream of another size than announced is no result") {
  for (const std::string& packed : {kOwnCodes, kFixedCodes}) {
    CHECK(!inflate(packed, numbers().size() - 1));
    CHECK(!inflate(packed, numbers().size() + 1));
    CHECK(!inflate(packed, 0));
  }
}

TEST_CASE("a stream cut or damaged anywhere gives nothing or bytes of the right number") {
  for (const std::string& good : {kOwnCodes, kFixedCodes, kStored, kRepeated}) {
    const std::size_t size = good == kStored ? 12 : good == kRepeated ? 3000 : numbers().size();
    for (std::size_t cut = 0; cut < good.size(); ++cut) CHECK(!inflate(good.substr(0, cut), size));
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      std::string damaged = good;
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
      const std::optional<std::string> result = inflate(damaged, size);
      if (result) CHECK(result->size() == size);
    }
  }
}

TEST_CASE("check sums are those of ZIP") {
  CHECK(crc32("123456789") == 0xcbf43926u);
  CHECK(crc32(numbers()) == 2098386588u);
  CHECK(crc32("") == 0);
}
