#include "mesh/parts.h"

#include <doctest/doctest.h>

#include "grid_mesh.h"

using namespace s3;

namespace {

TriMesh box(const Vec3& low, const Vec3& size) {
  TriMesh mesh = boundary_surface(test::make_grid(1, 1, 1, size));
  mesh.vertices.rowwise() += low.transpose();
  return mesh;
}

struct File {
  TriMesh surface{Points(0, 3), Triangles(0, 3)};
  std::vector<Index> part_of_triangle;
  std::vector<std::string> names;

  void add(const TriMesh& mesh, const std::string& name) {
    const auto first = static_cast<Index>(surface.vertices.rows());
    const Eigen::Index row = surface.triangles.rows();
    surface.vertices.conservativeResize(first + mesh.vertices.rows(), 3);
    surface.vertices.bottomRows(mesh.vertices.rows()) = mesh.vertices;
    surface.triangles.conservativeResize(row + mesh.triangles.rows(), 3);
    surface.triangles.bottomRows(mesh.triangles.rows()) = mesh.triangles.array() + first;
    part_of_triangle.resize(static_cast<std::size_t>(surface.triangles.rows()),
                            static_cast<Index>(names.size()));
    names.push_back(name);
  }

  InputParams stand(Context& ctx, const InputParams& params = {}) {
    std::vector<Orientation> orientations;
    return stand_parts(surface, part_of_triangle, names, params, orientations, ctx);
  }

  /// The box of a part of one of box()'s surfaces.
  Box part_box(Index part) const { return bounding_box(surface.vertices.middleRows(8 * part, 8)); }
};

std::vector<std::string> codes(const Context& ctx) {
  std::vector<std::string> codes;
  for (const Warning& warning : ctx.warnings) codes.push_back(warning.code);
  return codes;
}

}  // namespace

TEST_CASE("parts at several heights are each put onto the plate") {
  File file;
  file.add(box(Vec3(0, 0, 3), Vec3(2, 2, 2)), "low");
  file.add(box(Vec3(10, 0, 7), Vec3(2, 2, 4)), "high");
  Context ctx;
  file.stand(ctx);
  CHECK(file.part_box(0).min.z() == doctest::Approx(3));
  CHECK(file.part_box(1).min.z() == doctest::Approx(3));
  CHECK(file.part_box(1).max.z() == doctest::Approx(7));
  CHECK(file.part_box(1).min.x() == doctest::Approx(10));
  CHECK(codes(ctx) == std::vector<std::string>{"mesh.dropped_parts"});
}

TEST_CASE("parts are put onto the plate below them after the rotation") {
  File file;
  file.add(box(Vec3(0, 0, 0), Vec3(2, 2, 2)), "a");
  file.add(box(Vec3(10, 5, 1), Vec3(2, 2, 2)), "b");
  Context ctx;
  file.stand(ctx, {.up = "y", .scale = 3});  // the plate is at y = 0 of the file
  CHECK(file.part_box(1).min.y() == doctest::Approx(0));
  CHECK(file.part_box(1).min.z() == doctest::Approx(1));
  CHECK(codes(ctx) == std::vector<std::string>{"mesh.dropped_parts"});
}

TEST_CASE("parts that stand on the plate already stay, without a word") {
  File file;
  file.add(box(Vec3(0, 0, 1), Vec3(2, 2, 2)), "a");
  file.add(box(Vec3(5, 0, 1), Vec3(2, 2, 9)), "b");
  const Points before = file.surface.vertices;
  Context ctx;
  file.stand(ctx);
  CHECK(file.surface.vertices == before);
  CHECK(ctx.warnings.empty());
}

TEST_CASE("parts that overlap, touch or contain each other keep together") {
  for (const Vec3& low : {Vec3(1, 1, 1), Vec3(0.5, 0.5, 2), Vec3(0.2, 0.2, 0.2)}) {
    File file;
    file.add(box(Vec3(0, 0, 0), Vec3(2, 2, 2)), "body");
    file.add(box(low, Vec3(1.5, 1.5, 1.5)), "");
    file.add(box(Vec3(9, 9, 4), Vec3(1, 1, 1)), "far");
    Context ctx;
    const auto contacts = part_contacts(file.surface, file.part_of_triangle, 3, ctx);
    REQUIRE(contacts.size() == 1);
    CHECK(contacts[0].first == 0);
    CHECK(contacts[0].second == 1);
    file.stand(ctx);
    CHECK(file.part_box(1).min.z() == doctest::Approx(low.z()));
    CHECK(file.part_box(2).min.z() == doctest::Approx(0));
    REQUIRE(codes(ctx) == std::vector<std::string>{"mesh.merged_parts", "mesh.dropped_parts"});
    CHECK(ctx.warnings[0].message.find("'body' and part 2") != std::string::npos);
  }
}

TEST_CASE("a part above another one cannot be put onto the plate") {
  File file;
  file.add(box(Vec3(0, 0, 0), Vec3(4, 4, 2)), "table");
  file.add(box(Vec3(1, 1, 3), Vec3(1, 1, 1)), "vase");
  const Points before = file.surface.vertices;
  Context ctx;
  file.stand(ctx);
  CHECK(file.surface.vertices == before);
  CHECK(codes(ctx) == std::vector<std::string>{"mesh.parts_collide"});
}

TEST_CASE("a search with several parts is done once, and written out") {
  File file;
  file.add(box(Vec3(0, 0, 0), Vec3(2, 20, 20)), "a");
  file.add(box(Vec3(10, 0, 0), Vec3(2, 20, 20)), "b");
  Context ctx;
  std::vector<Orientation> orientations;
  const InputParams input = stand_parts(file.surface, file.part_of_triangle, file.names,
                                        {.rotate = "auto"}, orientations, ctx);
  REQUIRE(!orientations.empty());
  CHECK(input.rotate == orientations[0].rotate);
  Points placed = file.surface.vertices;
  transform_points(placement(placed, file.surface.triangles, input), placed);
  for (Index part = 0; part < 2; ++part)
    CHECK(placed.middleRows(8 * part, 8).col(2).minCoeff() == doctest::Approx(0));
}

TEST_CASE("a body in the air is warned about, a cavity and what stands are not") {
  File file;
  file.add(box(Vec3(0, 0, 0), Vec3(4, 4, 4)), "");
  TriMesh hole = box(Vec3(1, 1, 1), Vec3(2, 2, 2));
  hole.triangles.col(1).swap(hole.triangles.col(2));
  file.add(hole, "");
  file.add(box(Vec3(9, 0, 0), Vec3(1, 1, 1)), "");
  Context ctx;
  warn_about_floating_parts(file.surface, ctx);
  CHECK(ctx.warnings.empty());
  file.add(box(Vec3(20, 0, 1.5), Vec3(1, 1, 1)), "");
  warn_about_floating_parts(file.surface, ctx);
  REQUIRE(codes(ctx) == std::vector<std::string>{"mesh.floating_part"});
  CHECK(ctx.warnings[0].message.find("1.5 mm above the plate") != std::string::npos);
  REQUIRE(ctx.warnings[0].where.size() == 1);
  CHECK(ctx.warnings[0].where[0].x() >= 20);
}
