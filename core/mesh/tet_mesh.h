// A solid: tets with their neighbours, the face pairs N_F and the boundary B of the paper (Sec. 2).
#pragma once
#include <array>
#include <vector>

#include "base/types.h"
#include "mesh/tri_mesh.h"

namespace s3 {

/// The three corners of face i of a tet (the face opposite corner i), counter-clockwise seen from
/// outside the tet.
inline constexpr std::array<std::array<int, 3>, 4> kTetFaces = {
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

struct TetMesh {
  Points vertices;  // #V×3 mm
  Tets tets;        // #T×4, positive volume

  // Built once by build_topology().
  Tets neighbors;            // #T×4: the tet across face i, −1 outside
  Pairs face_pairs;          // #N×2 = N_F: face-adjacent tets, first < second
  Pairs face_pair_local;     // #N×2: the local face index of the shared face in the first and the
                             // second tet
  Triangles boundary_faces;  // #B×3, counter-clockwise from outside
  std::vector<Index> boundary_face_tet;  // #B: the tet behind each boundary face

  Index vertex_count() const { return static_cast<Index>(vertices.rows()); }
  Index tet_count() const { return static_cast<Index>(tets.rows()); }

  Vec3 corner(Index t, int i) const { return vertices.row(tets(t, i)).transpose(); }
  Vec3 centroid(Index t) const {
    return 0.25 * (corner(t, 0) + corner(t, 1) + corner(t, 2) + corner(t, 3));
  }
};

/// Makes a mesh with its topology from vertices and tets. Tets of negative volume are turned;
/// linear time.
/// @throws Error "mesh.bad_tets" for indices out of range, repeated corners, tets without volume,
/// or a face shared by
///         more than two tets
TetMesh make_tet_mesh(Points vertices, Tets tets);

double tet_volume(const Points& vertices, const Tets& tets, Index t);
/// #T volumes, mm³.
Values tet_volumes(const TetMesh& mesh);
/// The four gradients of the linear hat functions of a tet, as columns: ∇G = gradients · (G0, G1,
/// G2, G3)ᵀ. 1/mm.
Eigen::Matrix<double, 3, 4> hat_gradients(const TetMesh& mesh, Index t);
/// Mean length of the tets' edges (each tet's six edges count), mm.
double mean_edge_length(const TetMesh& mesh);
/// The boundary as a surface; vertex indices are those of the tet mesh (unused vertices stay).
TriMesh boundary_surface(const TetMesh& mesh);
/// One flag a boundary face: it lies on the plate. All three vertices within 1 % of the mesh's
/// height above its lowest point and n_z < −0.9 (the contract's rule for leaving faces out of
/// areas).
std::vector<char> plate_faces(const TetMesh& mesh);

}  // namespace s3
