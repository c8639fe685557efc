#include "pipeline/prepare_mesh.h"

#include <utility>

#include "mesh/placement.h"
#include "mesh/reorder.h"
#include "mesh/validate.h"

namespace s3 {
namespace {

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> inverse(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    inverse[static_cast<std::size_t>(order[i])] = static_cast<Index>(i);
  return inverse;
}

}  // namespace

void prepare_volume(ModelFile file, const InputParams& params, Artifacts& artifacts, Context& ctx) {
  TetMesh mesh = make_tet_mesh(std::move(file.vertices), std::move(file.tets));
  artifacts.placement =
      placement(mesh.vertices, mesh.boundary_faces, params, &artifacts.model.orientations, &ctx);
  transform_points(artifacts.placement, mesh.vertices);
  std::vector<Index> vertex_order, tet_order;
  artifacts.rest = reorder_along_morton(mesh, &vertex_order, &tet_order);
  artifacts.file_order = {inverse(vertex_order), inverse(tet_order)};
  artifacts.surface = boundary_surface(artifacts.rest);
  warn_about_units(bounding_box(artifacts.surface.vertices), ctx);
  artifacts.model.triangles = static_cast<Index>(artifacts.surface.triangles.rows());
  artifacts.model.volume = enclosed_volume(artifacts.surface);
}

void prepare_surface(ModelFile file, const InputParams& params, Artifacts& artifacts,
                     Context& ctx) {
  TriMesh surface = std::move(file.surface);
  artifacts.model.triangles = static_cast<Index>(surface.triangles.rows());
  artifacts.model.repairs = clean_surface(surface);
  require_valid_surface(inspect_surface(surface, &ctx));
  artifacts.placement =
      placement(surface.vertices, surface.triangles, params, &artifacts.model.orientations, &ctx);
  transform_points(artifacts.placement, surface.vertices);
  warn_about_units(bounding_box(surface.vertices), ctx);
  artifacts.model.volume = enclosed_volume(surface);
  artifacts.surface = std::move(surface);
}

}  // namespace s3
