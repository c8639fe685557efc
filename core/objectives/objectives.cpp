#include "objectives/objectives.h"

#include <algorithm>

#include "fea/loading.h"
#include "mesh/tri_mesh.h"

namespace s3 {

namespace {

// The contact is flat: vertices this close to the bottom, as a share of the height, and normals
// this close to −z.
constexpr double kContactHeight = 1e-3;
constexpr double kContactNormal = -0.999;

std::vector<char> contact_vertices(const TetMesh& rest, const Directions& face_normal) {
  const Box box = bounding_box(rest.vertices);
  const double limit = box.min.z() + kContactHeight * (box.max.z() - box.min.z());
  std::vector<char> on_plate(static_cast<std::size_t>(rest.vertex_count()), 0);
  bool any = false;
  for (Eigen::Index f = 0; f < rest.boundary_faces.rows(); ++f) {
    if (face_normal(f, 2) > kContactNormal) continue;
    bool low = true;
    for (int i = 0; i < 3; ++i) low = low && rest.vertices(rest.boundary_faces(f, i), 2) <= limit;
    if (!low) continue;
    any = true;
    for (int i = 0; i < 3; ++i) on_plate[rest.boundary_faces(f, i)] = 1;
  }
  if (any) return on_plate;
  // A round bottom: what touches the plate first.
  for (Index v = 0; v < rest.vertex_count(); ++v) on_plate[v] = rest.vertices(v, 2) <= limit;
  return on_plate;
}

void group_faces_by_tet(const TetMesh& rest, ObjectiveField& field) {
  field.tet_face_begin.assign(static_cast<std::size_t>(rest.tet_count()) + 1, 0);
  for (const Index t : rest.boundary_face_tet) ++field.tet_face_begin[t + 1];
  for (Index t = 0; t < rest.tet_count(); ++t) {
    if (field.tet_face_begin[t + 1] > 0) field.boundary_tets.push_back(t);
    field.tet_face_begin[t + 1] += field.tet_face_begin[t];
  }
  std::vector<Index> next(field.tet_face_begin.begin(), field.tet_face_begin.end() - 1);
  field.tet_faces.resize(rest.boundary_face_tet.size());
  for (std::size_t f = 0; f < rest.boundary_face_tet.size(); ++f)
    field.tet_faces[next[rest.boundary_face_tet[f]]++] = static_cast<Index>(f);
}

}  // namespace

ObjectiveField make_objectives(const TetMesh& rest, const ObjectiveParams& params,
                               const StressField* stress, const Region* surface_region) {
  ObjectiveField field;
  const Eigen::Index faces = rest.boundary_faces.rows();
  field.face_normal.resize(faces, 3);
  field.face_area.resize(faces);
  for (Eigen::Index f = 0; f < faces; ++f) {
    const Vec3 n = triangle_normal_2a(rest.vertices, rest.boundary_faces.row(f));
    field.face_normal.row(f) = n.normalized();
    field.face_area(f) = 0.5 * n.norm();
  }
  field.vertex_on_plate = contact_vertices(rest, field.face_normal);
  // Faces just above the contact belong to the first layer, whatever their slope: the same rule as
  // in the areas reported.
  field.face_exempt = plate_faces(rest);
  field.face_wants_quality.assign(static_cast<std::size_t>(faces), 0);
  if (surface_region != nullptr) {
    field.face_in_region.assign(static_cast<std::size_t>(faces), 0);
    for (const Index f : region_faces(rest, *surface_region, Stage::objectives))
      field.face_in_region[f] = 1;
  }
  if (params.surface_quality > 0)
    for (std::size_t f = 0; f < field.face_exempt.size(); ++f)
      field.face_wants_quality[f] =
          !field.face_exempt[f] && (surface_region == nullptr || field.face_in_region[f]);
  group_faces_by_tet(rest, field);
  if (params.strength > 0 && stress != nullptr) {
    field.critical.assign(static_cast<std::size_t>(rest.tet_count()), 0);
    for (const Index t : stress->critical_tets) field.critical[t] = 1;
    field.tau_max = stress->principal;
    field.tension = stress->principal_value;
  }
  return field;
}

}  // namespace s3
