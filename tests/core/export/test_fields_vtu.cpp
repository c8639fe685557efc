#include "export/fields_vtu.h"

#include <span>

#include <doctest/doctest.h>

#include "fea/read_stress.h"
#include "grid_mesh.h"
#include "mesh/read_vtu.h"
#include "mesh/reorder.h"

namespace {

s3::VtuFile read_back(const std::string& text) {
  return s3::read_vtu(std::as_bytes(std::span(text.data(), text.size())), "fields.vtu");
}

s3::DeformResult bent_result(const s3::TetMesh& mesh) {
  s3::Values g(mesh.vertex_count());
  for (s3::Index v = 0; v < mesh.vertex_count(); ++v)
    g(v) = mesh.vertices(v, 2) + 0.1 * mesh.vertices(v, 0) * mesh.vertices(v, 1) + 1.0 / 3;
  s3::DeformResult result;
  result.field = s3::make_scalar_field(mesh, g);
  result.deformed = 1.1 * mesh.vertices;
  result.rotation.resize(mesh.tet_count(), 4);
  for (s3::Index t = 0; t < mesh.tet_count(); ++t) result.rotation.row(t) << 0.1 * t, 0.2, 0.3, 1;
  return result;
}

}  // namespace

TEST_CASE("fields.vtu holds the mesh and every field to the last bit") {
  const auto mesh = s3::test::make_grid(2, 1, 2, {3, 2, 4});
  const auto result = bent_result(mesh);
  const auto file = read_back(s3::write_fields_vtu(mesh, result, nullptr, {}));
  CHECK(file.vertices == mesh.vertices);
  CHECK(file.tets == mesh.tets);
  REQUIRE(file.point_data.contains("G"));
  for (s3::Index v = 0; v < mesh.vertex_count(); ++v)
    CHECK(file.point_data.at("G").values[static_cast<std::size_t>(v)] == result.field.value(v));
  const auto& lpd = file.cell_data.at("lpd");
  const auto& rotation = file.cell_data.at("quaternion");
  CHECK(lpd.components == 3);
  CHECK(rotation.components == 4);
  CHECK(file.point_data.at("deformed").components == 3);
  for (s3::Index t = 0; t < mesh.tet_count(); ++t) {
    const auto i = static_cast<std::size_t>(t);
    CHECK(lpd.values[3 * i + 1] == result.field.print_direction(t, 1));
    CHECK(rotation.values[4 * i] == 0.1 * t);
  }
  CHECK_FALSE(file.cell_data.contains("tau_max"));
}

TEST_CASE("a renumbered mesh is written in the order of its file") {
  const auto original = s3::test::make_grid(3, 2, 2, {3, 2, 4});
  std::vector<s3::Index> vertex_order, tet_order;
  const auto mesh = s3::reorder_along_morton(original, &vertex_order, &tet_order);
  s3::FileOrder order{std::vector<s3::Index>(vertex_order.size()),
                      std::vector<s3::Index>(tet_order.size())};
  for (std::size_t i = 0; i < vertex_order.size(); ++i)
    order.vertices[static_cast<std::size_t>(vertex_order[i])] = static_cast<s3::Index>(i);
  for (std::size_t i = 0; i < tet_order.size(); ++i)
    order.tets[static_cast<std::size_t>(tet_order[i])] = static_cast<s3::Index>(i);
  const auto result = bent_result(mesh);
  s3::StressField stress;
  stress.principal = s3::Vec3(0, 0, 1).transpose().replicate(mesh.tet_count(), 1);
  stress.principal_value = s3::Values::LinSpaced(mesh.tet_count(), 0, 1);
  stress.critical_tets = {4, 7};
  const auto file = read_back(s3::write_fields_vtu(mesh, result, &stress, order));
  CHECK(file.vertices == original.vertices);
  CHECK(file.tets == original.tets);
  const auto expected = bent_result(original);
  for (s3::Index v = 0; v < original.vertex_count(); ++v)
    CHECK(file.point_data.at("G").values[static_cast<std::size_t>(v)] == expected.field.value(v));
  int critical = 0;
  for (std::size_t t = 0; t < tet_order.size(); ++t) {
    critical += file.cell_data.at("critical").values[t] == 1 ? 1 : 0;
    const auto row = static_cast<std::size_t>(order.tets[t]);
    CHECK(file.cell_data.at("sigma_max").values[t] ==
          stress.principal_value(static_cast<s3::Index>(row)));
  }
  CHECK(critical == 2);
  CHECK(file.cell_data.at("critical").values[static_cast<std::size_t>(tet_order[4])] == 1);
  CHECK(file.cell_data.at("tau_max").values[2] == 1);
}

TEST_CASE("stress tensors in fields.vtu are read back as an imported stress") {
  const auto mesh = s3::test::make_grid(2, 1, 2, {3, 2, 4});
  s3::Context ctx;
  s3::StressField stress = s3::stress_field(s3::Tensors::Random(mesh.tet_count(), 6), ctx);
  stress.critical_tets = s3::critical_tets(stress.principal_value, 0.3);
  const std::string text = s3::write_fields_vtu(mesh, bent_result(mesh), &stress, {});
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  const s3::StressField back = s3::read_stress(bytes, "fields.vtu", mesh.tet_count(), 0.3);
  CHECK(back.stress == stress.stress);
  CHECK(back.principal == stress.principal);
  CHECK(back.principal_value == stress.principal_value);
  CHECK(back.critical_tets == stress.critical_tets);
}
