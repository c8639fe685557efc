// Linear systems like the pipeline's, for tests and benchmarks of the solvers.
#pragma once
#include <random>
#include <vector>

#include "math/sparse_solver.h"
#include "mesh/tet_mesh.h"

namespace s3::test {

using Entries = std::vector<Eigen::Triplet<double, Index>>;

inline SparseMatrix assemble(Index rows, const Entries& entries) {
  SparseMatrix A(rows, rows);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// Seven-point Laplacian of an n³ grid with zero boundary values.
inline SparseMatrix grid_laplacian(int n) {
  Entries entries;
  const auto id = [&](int i, int j, int k) { return static_cast<Index>((k * n + j) * n + i); };
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        entries.emplace_back(id(i, j, k), id(i, j, k), 6.0);
        const auto join = [&](int a, int b, int c) {
          if (a >= n || b >= n || c >= n) return;
          entries.emplace_back(id(i, j, k), id(a, b, c), -1.0);
          entries.emplace_back(id(a, b, c), id(i, j, k), -1.0);
        };
        join(i + 1, j, k);
        join(i, j + 1, k);
        join(i, j, k + 1);
      }
  return assemble(n * n * n, entries);
}

/// Eq. 8: the face-adjacency Laplacian of the tets with weights in [1, 1 + spread], and a diagonal
/// on every tet that touches the boundary and whose centroid lies below `held_below`.
inline SparseMatrix blend_system(const TetMesh& mesh, double keep_weight, double held_below,
                                 double spread = 0) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform;
  Entries entries;
  for (Eigen::Index f = 0; f < mesh.face_pairs.rows(); ++f) {
    const Index a = mesh.face_pairs(f, 0), b = mesh.face_pairs(f, 1);
    const double w = 1 + spread * uniform(random);
    entries.emplace_back(a, a, w);
    entries.emplace_back(b, b, w);
    entries.emplace_back(a, b, -w);
    entries.emplace_back(b, a, -w);
  }
  for (const Index t : mesh.boundary_face_tet)
    if (mesh.centroid(t).z() < held_below) entries.emplace_back(t, t, keep_weight);
  return assemble(mesh.tet_count(), entries);
}

/// The refinement's system on vertices: w0 M + w1 Σ_tets vol ∇φᵀ∇φ + w2 Σ_faces area·h |jump of
/// ∇φ|², h the mean edge.
inline SparseMatrix refinement_system(const TetMesh& mesh, double w0, double w1, double w2) {
  using Gradients = Eigen::Matrix<double, 3, 4>;
  Entries entries;
  std::vector<Gradients> gradients;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    gradients.push_back(hat_gradients(mesh, t));
    const double volume = tet_volume(mesh.vertices, mesh.tets, t);
    const Eigen::Matrix4d stiffness = volume * gradients.back().transpose() * gradients.back();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        entries.emplace_back(mesh.tets(t, i), mesh.tets(t, j),
                             w1 * stiffness(i, j) + (i == j ? w0 * volume / 4 : 0));
  }
  const double h = mean_edge_length(mesh);
  for (Eigen::Index f = 0; f < mesh.face_pairs.rows(); ++f) {
    const Index a = mesh.face_pairs(f, 0), b = mesh.face_pairs(f, 1);
    // The five vertices of the pair: a's four, and the one of b opposite the shared face.
    std::array<Index, 5> vertex;
    Eigen::Matrix<double, 3, 5> jump = Eigen::Matrix<double, 3, 5>::Zero();
    for (int i = 0; i < 4; ++i) vertex[i] = mesh.tets(a, i);
    vertex[4] = mesh.tets(b, mesh.face_pair_local(f, 1));
    jump.leftCols<4>() = gradients[a];
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 5; ++i)
        if (vertex[i] == mesh.tets(b, j)) jump.col(i) -= gradients[b].col(j);
    const auto face = kTetFaces[mesh.face_pair_local(f, 0)];
    const Vec3 p = mesh.corner(a, face[0]);
    const double area =
        0.5 * (mesh.corner(a, face[1]) - p).cross(mesh.corner(a, face[2]) - p).norm();
    const Eigen::Matrix<double, 5, 5> energy = w2 * area * h * jump.transpose() * jump;
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j) entries.emplace_back(vertex[i], vertex[j], energy(i, j));
  }
  return assemble(mesh.vertex_count(), entries);
}

/// Linear elasticity (Young's modulus 1, Poisson's ratio 0.35) with springs on the vertices below
/// `held_below`.
inline SparseMatrix elasticity_system(const TetMesh& mesh, double held_below) {
  const double nu = 0.35, mu = 1 / (2 * (1 + nu)), lambda = nu / ((1 + nu) * (1 - 2 * nu));
  Entries entries;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    const Eigen::Matrix<double, 3, 4> g = hat_gradients(mesh, t);
    const double volume = tet_volume(mesh.vertices, mesh.tets, t);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const Mat3 block = volume * (lambda * g.col(i) * g.col(j).transpose() +
                                     mu * g.col(j) * g.col(i).transpose() +
                                     mu * g.col(i).dot(g.col(j)) * Mat3::Identity());
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            entries.emplace_back(3 * mesh.tets(t, i) + r, 3 * mesh.tets(t, j) + c, block(r, c));
      }
  }
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.vertices(v, 2) < held_below)
      for (int r = 0; r < 3; ++r) entries.emplace_back(3 * v + r, 3 * v + r, 10.0);
  return assemble(3 * mesh.vertex_count(), entries);
}

/// #3V×6: translations and rotations about the centre.
inline Block rigid_body_modes(const TetMesh& mesh) {
  Block modes = Block::Zero(3 * mesh.vertex_count(), 6);
  const Vec3 center = mesh.vertices.colwise().mean().transpose();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = mesh.vertices.row(v).transpose() - center;
    for (int c = 0; c < 3; ++c) {
      modes(3 * v + c, c) = 1;
      modes.block<3, 1>(3 * v, 3 + c) = Vec3::Unit(c).cross(p);
    }
  }
  return modes;
}

/// #V×4: the constant and the three coordinates, which every smoothness energy leaves alone.
inline Block linear_functions(const TetMesh& mesh) {
  Block functions(mesh.vertex_count(), 4);
  functions.col(0).setOnes();
  functions.rightCols<3>() = mesh.vertices.rowwise() - mesh.vertices.colwise().mean();
  return functions;
}

inline Block random_block(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Block B(rows, columns);
  for (Eigen::Index i = 0; i < B.size(); ++i) B.data()[i] = normal(random);
  return B;
}

}  // namespace s3::test
