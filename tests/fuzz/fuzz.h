// What every fuzz target does: read the bytes, accept Error and nothing else, and look at what came
// out.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "base/error.h"

namespace s3::fuzz {

/// Stops the fuzzer where a reader gave out a mesh that breaks its promise.
inline void require(bool promise) {
  if (!promise) std::abort();
}

/// Indices in range, coordinates finite.
template <class Points, class Elements>
void require_in_range(const Points& vertices, const Elements& elements) {
  require(vertices.allFinite());
  if (elements.size() > 0)
    require(elements.minCoeff() >= 0 && elements.maxCoeff() < vertices.rows());
}

template <class Read>
int run(const std::uint8_t* data, std::size_t size, Read&& read) {
  try {
    read(std::span(reinterpret_cast<const std::byte*>(data), size));
  } catch (const Error& error) {
    require(error.kind == ErrorKind::input && !error.code.empty());
  }
  return 0;
}

}  // namespace s3::fuzz
