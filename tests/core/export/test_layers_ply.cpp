#include "export/layers_ply.h"

#include <span>

#include <doctest/doctest.h>

#include "base/error.h"

namespace {

s3::Layer two_triangles() {
  s3::Layer layer;
  layer.surface.vertices.resize(4, 3);
  layer.surface.vertices << 0, 0, 1.0 / 3, 1, 0, 0.3, 1, 1, 0.3, 0, 1, 0.3;
  layer.surface.triangles.resize(2, 3);
  layer.surface.triangles << 0, 1, 2, 0, 2, 3;
  layer.normal = s3::Vec3(0, 0, 1).transpose().replicate(4, 1);
  layer.thickness = s3::Values::LinSpaced(4, 0.4, 1);
  layer.iso_value = 0.1 + 0.2;
  layer.layer = 12;
  layer.partial = true;
  return layer;
}

s3::Layer read(const std::string& text) {
  return s3::read_layer_ply(std::as_bytes(std::span(text.data(), text.size())), "0000.ply");
}

}  // namespace

TEST_CASE("a layer written as PLY and read back is the same to the last bit") {
  const auto layer = two_triangles();
  const auto back = read(s3::write_layer_ply(layer));
  CHECK(back.surface.vertices == layer.surface.vertices);
  CHECK(back.surface.triangles == layer.surface.triangles);
  CHECK(back.normal == layer.normal);
  CHECK(back.thickness == layer.thickness);
  CHECK(back.iso_value == layer.iso_value);
  CHECK(back.layer == 12);
  CHECK(back.partial);
}

TEST_CASE("files are numbered in print order") {
  CHECK(s3::layer_file_name(0) == "layers/0000.ply");
  CHECK(s3::layer_file_name(123) == "layers/0123.ply");
  CHECK(s3::layer_file_name(12345) == "layers/12345.ply");
}

TEST_CASE("no damaged layer file is read, wherever the damage is") {
  const std::string good = s3::write_layer_ply(two_triangles());
  for (std::size_t length = 0; length < good.size(); ++length)
    CHECK_THROWS_AS(read(good.substr(0, length)), s3::Error);
  CHECK_THROWS_AS(read(good + "x"), s3::Error);
  std::string huge = good;
  huge.replace(huge.find("vertex 4"), 8, "vertex 2000000000");
  CHECK_THROWS_AS(read(huge), s3::Error);
  std::string outside = good;
  outside[outside.size() - 2] = '\x7f';  // the last index, now far beyond the vertices
  CHECK_THROWS_AS(read(outside), s3::Error);
}
