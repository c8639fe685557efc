#include "mesh/write_mesh.h"

#include <doctest/doctest.h>

#include <cmath>

#include "grid_mesh.h"
#include "mesh/read_mesh.h"

using namespace s3;

namespace {

ModelFile read(const std::string& bytes, const char* name) {
  return read_model({reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()}, name);
}

TetMesh bent_bar() {
  return test::make_grid(4, 3, 2, Vec3(4, 3, 2) / 7, [](const Vec3& p) {
    return Vec3(p.x() + 0.1 * std::sin(p.z()), p.y() / 3, p.z() * 1e-3);
  });
}

}  // namespace

TEST_CASE("text formats come back with every digit") {
  const TetMesh bar = bent_bar();
  const TriMesh surface = boundary_surface(bar);
  for (const auto& [text, name] :
       {std::pair{write_obj(surface), "a.obj"}, std::pair{write_off(surface), "a.off"}}) {
    const ModelFile model = read(text, name);
    CHECK(model.surface.vertices == surface.vertices);
    CHECK(model.surface.triangles == surface.triangles);
  }
  const ModelFile volume = read(write_tet(bar.vertices, bar.tets), "a.tet");
  CHECK(volume.vertices == bar.vertices);
  CHECK(volume.tets == bar.tets);
}

TEST_CASE("binary STL comes back in single precision, with its vertices joined again") {
  const TriMesh surface = boundary_surface(test::make_grid(4, 3, 2, Vec3(4, 3, 2)));
  const TriMesh back = read(write_stl(surface), "a.stl").surface;
  CHECK(back.triangles.rows() == surface.triangles.rows());
  CHECK(back.vertices.rows() ==
        2 + surface.triangles.rows() / 2);  // Euler: V = 2 + F/2 on a closed ball
  for (Eigen::Index f = 0; f < back.triangles.rows(); ++f)
    for (int i = 0; i < 3; ++i)
      CHECK(back.vertices.row(back.triangles(f, i)) ==
            surface.vertices.row(surface.triangles(f, i)));
}

TEST_CASE("numbers are written as short as they can be read back") {
  const auto written = [](double value) {
    std::string text;
    append_number(text, value);
    return text;
  };
  CHECK(written(0.1) == "0.1");
  CHECK(written(-3) == "-3");
  CHECK(written(1.0 / 3) == "0.3333333333333333");
}
