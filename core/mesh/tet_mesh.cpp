#include "mesh/tet_mesh.h"

#include <algorithm>
#include <string>

#include "base/error.h"

namespace s3 {

namespace {

// A face with sorted corners, for matching the two tets that share it.
struct FaceKey {
  std::array<Index, 3> corners;
  Index tet;
  std::int8_t local;
  bool operator<(const FaceKey& o) const {
    return corners != o.corners ? corners < o.corners : tet < o.tet;
  }
};

[[noreturn]] void bad_tets(const std::string& what, const std::string& hint) {
  throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_tets", what, hint);
}

void check_and_orient(const Points& vertices, Tets& tets) {
  if (tets.rows() == 0) bad_tets("The mesh has no tetrahedra", "Export a volume mesh");
  if (!vertices.allFinite())
    bad_tets("The mesh has a vertex that is not a number", "Export the mesh again");
  for (Index t = 0; t < tets.rows(); ++t) {
    for (int i = 0; i < 4; ++i) {
      if (tets(t, i) < 0 || tets(t, i) >= vertices.rows())
        bad_tets("Tet " + std::to_string(t) + " names vertex " + std::to_string(tets(t, i)) +
                     " of " + std::to_string(vertices.rows()),
                 "The file is damaged; export the mesh again");
    }
    const double volume = tet_volume(vertices, tets, t);
    if (volume < 0) std::swap(tets(t, 2), tets(t, 3));
    if (volume == 0)
      bad_tets("Tet " + std::to_string(t) + " has no volume", "Remesh the model without flat tets");
  }
}

}  // namespace

TetMesh make_tet_mesh(Points vertices, Tets tets) {
  check_and_orient(vertices, tets);
  TetMesh mesh;
  mesh.vertices = std::move(vertices);
  mesh.tets = std::move(tets);
  const Index n = mesh.tet_count();

  std::vector<FaceKey> faces;
  faces.reserve(4 * static_cast<std::size_t>(n));
  for (Index t = 0; t < n; ++t)
    for (int f = 0; f < 4; ++f) {
      FaceKey key{{mesh.tets(t, kTetFaces[f][0]), mesh.tets(t, kTetFaces[f][1]),
                   mesh.tets(t, kTetFaces[f][2])},
                  t,
                  static_cast<std::int8_t>(f)};
      std::sort(key.corners.begin(), key.corners.end());
      faces.push_back(key);
    }
  std::sort(faces.begin(), faces.end());

  mesh.neighbors.setConstant(n, 4, -1);
  for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
    if (faces[i].corners != faces[i + 1].corners) continue;
    if (i + 2 < faces.size() && faces[i].corners == faces[i + 2].corners)
      bad_tets("Tets " + std::to_string(faces[i].tet) + ", " + std::to_string(faces[i + 1].tet) +
                   " and " + std::to_string(faces[i + 2].tet) + " share one face",
               "Remove duplicate tets");
    mesh.neighbors(faces[i].tet, faces[i].local) = faces[i + 1].tet;
    mesh.neighbors(faces[i + 1].tet, faces[i + 1].local) = faces[i].tet;
  }

  // Both lists in tet order, so that whoever walks them walks memory.
  std::vector<std::array<Index, 4>> pairs;
  std::vector<std::array<Index, 3>> boundary;
  for (Index t = 0; t < n; ++t)
    for (int f = 0; f < 4; ++f) {
      const Index other = mesh.neighbors(t, f);
      if (other < 0) {
        boundary.push_back({mesh.tets(t, kTetFaces[f][0]), mesh.tets(t, kTetFaces[f][1]),
                            mesh.tets(t, kTetFaces[f][2])});
        mesh.boundary_face_tet.push_back(t);
      } else if (t < other) {
        int g = 0;
        while (mesh.neighbors(other, g) != t) ++g;
        pairs.push_back({t, other, f, g});
      }
    }
  mesh.face_pairs.resize(static_cast<Eigen::Index>(pairs.size()), 2);
  mesh.face_pair_local.resize(static_cast<Eigen::Index>(pairs.size()), 2);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto r = static_cast<Eigen::Index>(i);
    mesh.face_pairs.row(r) << pairs[i][0], pairs[i][1];
    mesh.face_pair_local.row(r) << pairs[i][2], pairs[i][3];
  }
  mesh.boundary_faces.resize(static_cast<Eigen::Index>(boundary.size()), 3);
  for (std::size_t i = 0; i < boundary.size(); ++i)
    mesh.boundary_faces.row(static_cast<Eigen::Index>(i)) << boundary[i][0], boundary[i][1],
        boundary[i][2];
  return mesh;
}

double tet_volume(const Points& vertices, const Tets& tets, Index t) {
  const Vec3 a = vertices.row(tets(t, 0)), b = vertices.row(tets(t, 1)),
             c = vertices.row(tets(t, 2)), d = vertices.row(tets(t, 3));
  return (b - a).dot((c - a).cross(d - a)) / 6.0;
}

Values tet_volumes(const TetMesh& mesh) {
  Values volumes(mesh.tet_count());
  for (Index t = 0; t < mesh.tet_count(); ++t) volumes(t) = tet_volume(mesh.vertices, mesh.tets, t);
  return volumes;
}

Eigen::Matrix<double, 3, 4> hat_gradients(const TetMesh& mesh, Index t) {
  // With edges e_i = v_i − v_0 as columns of E, ∇φ_i is row i of E⁻¹, and ∇φ_0 = −Σ ∇φ_i.
  const Vec3 e1 = mesh.corner(t, 1) - mesh.corner(t, 0), e2 = mesh.corner(t, 2) - mesh.corner(t, 0),
             e3 = mesh.corner(t, 3) - mesh.corner(t, 0);
  const double det = e1.dot(e2.cross(e3));
  Eigen::Matrix<double, 3, 4> g;
  g.col(1) = e2.cross(e3) / det;
  g.col(2) = e3.cross(e1) / det;
  g.col(3) = e1.cross(e2) / det;
  g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
  return g;
}

double mean_edge_length(const TetMesh& mesh) {
  double sum = 0;
  for (Index t = 0; t < mesh.tet_count(); ++t)
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) sum += (mesh.corner(t, i) - mesh.corner(t, j)).norm();
  return sum / (6.0 * mesh.tet_count());
}

TriMesh boundary_surface(const TetMesh& mesh) {
  return {mesh.vertices, mesh.boundary_faces};
}

std::vector<char> plate_faces(const TetMesh& mesh) {
  const Box box = bounding_box(mesh.vertices);
  const double limit = box.min.z() + 0.01 * (box.max.z() - box.min.z());
  std::vector<char> on_plate(static_cast<std::size_t>(mesh.boundary_faces.rows()), 0);
  for (Eigen::Index f = 0; f < mesh.boundary_faces.rows(); ++f) {
    bool low = true;
    for (int i = 0; i < 3; ++i) low = low && mesh.vertices(mesh.boundary_faces(f, i), 2) <= limit;
    if (!low) continue;
    const Vec3 n = triangle_normal_2a(mesh.vertices, mesh.boundary_faces.row(f));
    on_plate[static_cast<std::size_t>(f)] = n.z() < -0.9 * n.norm();
  }
  return on_plate;
}

}  // namespace s3
