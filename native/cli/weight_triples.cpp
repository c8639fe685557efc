#include "weight_triples.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "base/error.h"

namespace s3::cli {
namespace {

// A list longer than that is a mistake; so many runs take a day.
constexpr std::size_t kMostTriples = 1000;

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorKind::input, Stage::objectives, "params.bad_weights", why,
              "a triple is SF,SR,SQ with numbers from 0 to 1, not all 0: --weights \"0.7,0.3,0; "
              "0.5,0.25,0.25\"");
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\n") - first + 1);
}

/// The parts between the separators, trimmed.
std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto end = text.find(separator);
    parts.push_back(trimmed(text.substr(0, end)));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

WeightTriple parse_triple(std::string_view text) {
  const std::string name = "--weights \"" + std::string(text) + "\"";
  const auto parts = split(text, ',');
  std::array<double, 3> weight{};
  if (parts.size() != weight.size())
    refuse(name + " has " + std::to_string(parts.size()) + " numbers");
  for (std::size_t i = 0; i < weight.size(); ++i) {
    const char* end = parts[i].data() + parts[i].size();
    const auto [stop, error] = std::from_chars(parts[i].data(), end, weight[i]);
    if (error != std::errc() || stop != end)
      refuse(name + ": \"" + std::string(parts[i]) + "\" is not a number");
    if (!(weight[i] >= 0 && weight[i] <= 1))
      refuse(name + ": " + std::string(parts[i]) + " is not between 0 and 1");
  }
  if (weight[0] + weight[1] + weight[2] == 0) refuse(name + ": all weights are 0");
  return {weight[0], weight[1], weight[2]};
}

}  // namespace

std::vector<WeightTriple> triangular_grid(int steps) {
  std::vector<WeightTriple> triples;
  for (int support_free = steps; support_free >= 0; --support_free)
    for (int strength = steps - support_free; strength >= 0; --strength)
      triples.push_back({static_cast<double>(support_free) / steps,
                         static_cast<double>(strength) / steps,
                         static_cast<double>(steps - support_free - strength) / steps});
  return triples;
}

std::vector<WeightTriple> parse_triples(const std::vector<std::string>& texts) {
  std::vector<WeightTriple> triples;
  for (const std::string& text : texts)
    for (const std::string_view part : split(text, ';')) {
      if (part.empty()) continue;
      const WeightTriple triple = parse_triple(part);
      if (std::find(triples.begin(), triples.end(), triple) == triples.end())
        triples.push_back(triple);
      if (triples.size() > kMostTriples)
        refuse("--weights has more than " + std::to_string(kMostTriples) + " triples");
    }
  if (triples.empty()) refuse("--weights names no triple");
  return triples;
}

}  // namespace s3::cli
