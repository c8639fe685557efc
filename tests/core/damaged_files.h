// What every reader must stand: its files cut short anywhere and with bits turned.
#pragma once
#include <doctest/doctest.h>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
#include "mesh/read_mesh.h"

namespace s3::test {

inline ModelFile read(const std::string& text, std::string_view name) {
  return read_model(std::as_bytes(std::span(text)), name);
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  REQUIRE(text.find(from) != std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}

template <class Points, class Elements>
void check_in_range(const Points& vertices, const Elements& elements) {
  CHECK(vertices.allFinite());
  if (elements.size() == 0) return;
  CHECK(elements.minCoeff() >= 0);
  CHECK(elements.maxCoeff() < vertices.rows());
}

/// An input error, or a mesh whose indices, coordinates and parts are in range.
inline void check_read(const std::string& text, std::string_view name) {
  try {
    const ModelFile model = read(text, name);
    check_in_range(model.surface.vertices, model.surface.triangles);
    check_in_range(model.vertices, model.tets);
    REQUIRE(model.part_of_triangle.size() ==
            static_cast<std::size_t>(model.surface.triangles.rows()));
    for (const Index part : model.part_of_triangle) {
      CHECK(part >= 0);
      CHECK(static_cast<std::size_t>(part) < model.part_names.size());
    }
  } catch (const Error& e) {
    CHECK(e.kind == ErrorKind::input);
    CHECK(!e.hint.empty());
  }
}

/// Cuts the file after every byte and turns every bit, one at a time.
inline void check_damage(const std::string& good, std::string_view name) {
  CHECK_NOTHROW(read(good, name));
  for (std::size_t size = 0; size < good.size(); ++size) check_read(good.substr(0, size), name);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string damaged = good;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    check_read(damaged, name);
  }
}

}  // namespace s3::test
