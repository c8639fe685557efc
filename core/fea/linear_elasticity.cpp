#include "fea/linear_elasticity.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "base/error.h"
#include "math/sparse_solver.h"

namespace s3 {
namespace {

using StrainBlock = Eigen::Matrix<double, 6, 3>;  // a corner's displacement to the tet's strain

constexpr std::size_t kGrain = 1024;  // rows of blocks, or tets
// A solution this good is used with a warning, a worse one is not.
constexpr double kUsable = 1e-4;

StrainBlock strain_block(const Vec3& g) {
  StrainBlock B;
  B << g.x(), 0, 0,  //
      0, g.y(), 0,   //
      0, 0, g.z(),   //
      0, g.z(), g.y(), g.z(), 0, g.x(), g.y(), g.x(), 0;
  return B;
}

/// The vertices that a system has unknowns for, three each, in the order of the mesh.
struct Unknowns {
  std::vector<Index> vertex;  // of an unknown block
  std::vector<Index> block;   // of a vertex; −1 for vertices held along all axes or in no tet
};

constexpr std::uint8_t kAllHeld = 7;

/// The tets around every vertex.
struct Stars {
  std::vector<Index> start, tet;

  explicit Stars(const TetMesh& mesh)
      : start(static_cast<std::size_t>(mesh.vertex_count()) + 1, 0) {
    for (Eigen::Index i = 0; i < mesh.tets.size(); ++i) ++start[mesh.tets.data()[i] + 1];
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    tet.resize(static_cast<std::size_t>(mesh.tets.size()));
    std::vector<Index> next(start.begin(), start.end() - 1);
    for (Index t = 0; t < mesh.tet_count(); ++t)
      for (int i = 0; i < 4; ++i) tet[next[mesh.tets(t, i)]++] = t;
  }
};

Unknowns choose_unknowns(const Stars& stars, const std::vector<std::uint8_t>& held) {
  Unknowns unknowns;
  unknowns.block.assign(held.size(), -1);
  for (std::size_t v = 0; v < held.size(); ++v) {
    if (held[v] == kAllHeld || stars.start[v] == stars.start[v + 1]) continue;
    unknowns.block[v] = static_cast<Index>(unknowns.vertex.size());
    unknowns.vertex.push_back(static_cast<Index>(v));
  }
  return unknowns;
}

/// K without its held axes, and the right-hand sides of loadings that hold the same ones. A held
/// axis of a vertex that is free along others keeps a row of its own: K_ii u_i = K_ii u_held.
class Assembly {
 public:
  Assembly(const TetMesh& mesh, const ElasticBody& body, const Stars& stars,
           std::vector<const Loading*> loadings, Context& ctx)
      : mesh_(mesh),
        body_(body),
        stars_(stars),
        loadings_(std::move(loadings)),
        held_(loadings_.front()->held),
        unknowns_(choose_unknowns(stars, held_)) {
    lay_out();
    ctx.checkpoint();
    parallel_for(ctx.pool, unknowns_.vertex.size(), kGrain,
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t i = begin; i < end; ++i) fill(static_cast<Index>(i));
                 });
  }

  const SparseMatrix& matrix() const { return matrix_; }
  const Block& right_hand_sides() const { return right_; }
  const Unknowns& unknowns() const { return unknowns_; }
  bool is_held(Index v, int axis) const { return (held_[v] >> axis & 1) != 0; }

  /// Translations and rotations about the centre; nothing along held axes.
  Block rigid_body_modes() const {
    const auto count = static_cast<Index>(unknowns_.vertex.size());
    Vec3 center = Vec3::Zero();
    for (const Index v : unknowns_.vertex) center += mesh_.vertices.row(v).transpose();
    center /= std::max<Index>(1, count);
    Block modes = Block::Zero(3 * static_cast<Eigen::Index>(count), 6);
    for (Index i = 0; i < count; ++i) {
      const Index v = unknowns_.vertex[i];
      const Vec3 p = mesh_.vertices.row(v).transpose() - center;
      for (int c = 0; c < 3; ++c) {
        modes(3 * i + c, c) = 1;
        modes.block<3, 1>(3 * i, 3 + c) = Vec3::Unit(c).cross(p);
      }
      for (int axis = 0; axis < 3; ++axis)
        if (is_held(v, axis)) modes.row(3 * i + axis).setZero();
    }
    return modes;
  }

 private:
  /// The pattern: a 3×3 block for every vertex and its neighbours that have unknowns.
  void lay_out() {
    const auto count = static_cast<Index>(unknowns_.vertex.size());
    neighbour_start_.assign(static_cast<std::size_t>(count) + 1, 0);
    std::vector<Index> near;
    for (Index i = 0; i < count; ++i) {
      near.clear();
      const Index v = unknowns_.vertex[i];
      for (Index k = stars_.start[v]; k < stars_.start[v + 1]; ++k)
        for (int c = 0; c < 4; ++c)
          if (const Index j = unknowns_.block[mesh_.tets(stars_.tet[k], c)]; j >= 0)
            near.push_back(j);
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      neighbour_.insert(neighbour_.end(), near.begin(), near.end());
      neighbour_start_[i + 1] = static_cast<Index>(neighbour_.size());
    }
    const Eigen::Index rows = 3 * static_cast<Eigen::Index>(count);
    matrix_.resize(rows, rows);
    matrix_.resizeNonZeros(static_cast<Eigen::Index>(9 * neighbour_.size()));
    right_ = Block::Zero(rows, static_cast<Eigen::Index>(loadings_.size()));
    Index* outer = matrix_.outerIndexPtr();
    for (Index i = 0; i < count; ++i) {
      const Index first = neighbour_start_[i], length = neighbour_start_[i + 1] - first;
      for (int r = 0; r < 3; ++r) {
        outer[3 * i + r] = 9 * first + 3 * length * r;
        for (Index k = 0; k < 3 * length; ++k) {
          matrix_.innerIndexPtr()[outer[3 * i + r] + k] = 3 * neighbour_[first + k / 3] + k % 3;
          matrix_.valuePtr()[outer[3 * i + r] + k] = 0;
        }
      }
    }
    outer[rows] = static_cast<Index>(9 * neighbour_.size());
  }

  double* entry(Index i, int r, Index j) {
    const auto first = neighbour_.begin() + neighbour_start_[i];
    const auto found = std::lower_bound(first, neighbour_.begin() + neighbour_start_[i + 1], j);
    return matrix_.valuePtr() + matrix_.outerIndexPtr()[3 * i + r] + 3 * (found - first);
  }

  /// The three rows of one vertex, from the tets around it.
  void fill(Index i) {
    const Index v = unknowns_.vertex[i];
    for (std::size_t l = 0; l < loadings_.size(); ++l)
      for (int r = 0; r < 3; ++r)
        right_(3 * i + r, static_cast<Eigen::Index>(l)) = loadings_[l]->force(v, r);
    for (Index k = stars_.start[v]; k < stars_.start[v + 1]; ++k) {
      const Index t = stars_.tet[k];
      const Eigen::Matrix<double, 3, 4> gradients = hat_gradients(mesh_, t);
      int own = 0;
      while (mesh_.tets(t, own) != v) ++own;
      const Eigen::Matrix<double, 3, 6> stress = tet_volume(mesh_.vertices, mesh_.tets, t) *
                                                 strain_block(gradients.col(own)).transpose() *
                                                 body_.of_tet(t);
      for (int c = 0; c < 4; ++c) add(i, mesh_.tets(t, c), stress * strain_block(gradients.col(c)));
    }
    for (int r = 0; r < 3; ++r)
      if (is_held(v, r))
        for (std::size_t l = 0; l < loadings_.size(); ++l)
          right_(3 * i + r, static_cast<Eigen::Index>(l)) =
              *(entry(i, r, i) + r) * loadings_[l]->displacement(v, r);
  }

  void add(Index i, Index other, const Mat3& block) {
    const Index v = unknowns_.vertex[i], j = unknowns_.block[other];
    for (int r = 0; r < 3; ++r) {
      double* row = j >= 0 ? entry(i, r, j) : nullptr;
      for (int q = 0; q < 3; ++q) {
        const bool diagonal = v == other && r == q;
        if (is_held(v, r) && !diagonal) continue;
        if (is_held(other, q) && !diagonal) {
          for (std::size_t l = 0; l < loadings_.size(); ++l)
            right_(3 * i + r, static_cast<Eigen::Index>(l)) -=
                block(r, q) * loadings_[l]->displacement(other, q);
          continue;
        }
        row[q] += block(r, q);
      }
    }
  }

  const TetMesh& mesh_;
  const ElasticBody& body_;
  const Stars& stars_;
  std::vector<const Loading*> loadings_;
  const std::vector<std::uint8_t>& held_;
  Unknowns unknowns_;
  std::vector<Index> neighbour_start_, neighbour_;
  SparseMatrix matrix_;
  Block right_;
};

void check(const SolveReport& report, const ElasticSolverOptions& options, Context& ctx) {
  if (report.converged) return;
  std::array<char, 200> text;
  std::snprintf(text.data(), text.size(),
                "The displacements came within %.1e of equilibrium in %d iterations, not within "
                "the %.0e asked for",
                report.relative_residual, report.iterations, options.tolerance);
  if (report.relative_residual <= kUsable) {
    ctx.warn("fea.loose_solution", text.data());
    return;
  }
  throw Error(ErrorKind::slicing, Stage::fea, "fea.no_convergence", std::string(text.data()) + ".",
              "Check the mesh for very flat tets, and the load case for a part that hangs by a few "
              "vertices.");
}

/// Loadings with equal held axes, in the order of the first of each group.
std::vector<std::vector<std::size_t>> groups_of(const std::vector<Loading>& loadings) {
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t l = 0; l < loadings.size(); ++l) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
      return loadings[group.front()].held == loadings[l].held;
    });
    if (same == groups.end())
      groups.push_back({l});
    else
      same->push_back(l);
  }
  return groups;
}

Points held_displacement(const Loading& loading) {
  Points displacement = Points::Zero(loading.displacement.rows(), 3);
  for (Eigen::Index v = 0; v < displacement.rows(); ++v)
    for (int axis = 0; axis < 3; ++axis)
      if ((loading.held[static_cast<std::size_t>(v)] >> axis & 1) != 0)
        displacement(v, axis) = loading.displacement(v, axis);
  return displacement;
}

void solve_group(const TetMesh& mesh, const ElasticBody& body, const Stars& stars,
                 const std::vector<Loading>& loadings, const std::vector<std::size_t>& group,
                 const ElasticSolverOptions& options, std::vector<Points>& displacements,
                 Context& ctx) {
  std::vector<const Loading*> members;
  members.reserve(group.size());
  for (const std::size_t l : group) members.push_back(&loadings[l]);
  const Assembly assembly(mesh, body, stars, members, ctx);
  const Unknowns& unknowns = assembly.unknowns();
  Block X = Block::Zero(assembly.right_hand_sides().rows(), assembly.right_hand_sides().cols());
  if (X.rows() > 0) {
    const auto solver = make_solver({.kind = SolverKind::multigrid,
                                     .tolerance = options.tolerance,
                                     .max_iterations = options.max_iterations,
                                     .near_nullspace = assembly.rigid_body_modes(),
                                     .block_size = 3});
    solver->factor(assembly.matrix(), ctx);
    check(solver->solve(assembly.right_hand_sides(), X, ctx), options, ctx);
  }
  for (std::size_t m = 0; m < group.size(); ++m) {
    Points& displacement = displacements[group[m]];
    displacement = held_displacement(loadings[group[m]]);
    for (std::size_t i = 0; i < unknowns.vertex.size(); ++i)
      for (int axis = 0; axis < 3; ++axis)
        if (!assembly.is_held(unknowns.vertex[i], axis))
          displacement(unknowns.vertex[i], axis) =
              X(static_cast<Eigen::Index>(3 * i) + axis, static_cast<Eigen::Index>(m));
  }
}

}  // namespace

std::vector<Points> solve_elasticity(const TetMesh& mesh, const ElasticBody& body,
                                     const std::vector<Loading>& loadings,
                                     const ElasticSolverOptions& options, Context& ctx) {
  const Stars stars(mesh);
  std::vector<Points> displacements(loadings.size());
  for (const std::vector<std::size_t>& group : groups_of(loadings))
    solve_group(mesh, body, stars, loadings, group, options, displacements, ctx);
  return displacements;
}

Tensors strains(const TetMesh& mesh, const Points& displacement, Context& ctx) {
  Tensors result(mesh.tet_count(), 6);
  parallel_for(ctx.pool, static_cast<std::size_t>(mesh.tet_count()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = begin; i < end; ++i) {
                   const auto t = static_cast<Index>(i);
                   const Eigen::Matrix<double, 3, 4> gradients = hat_gradients(mesh, t);
                   Vector6 strain = Vector6::Zero();
                   for (int c = 0; c < 4; ++c)
                     strain += strain_block(gradients.col(c)) *
                               displacement.row(mesh.tets(t, c)).transpose();
                   result.row(t) = strain.transpose();
                 }
               });
  return result;
}

Tensors stresses(const ElasticBody& body, const Tensors& strains, Context& ctx) {
  Tensors result(strains.rows(), 6);
  parallel_for(ctx.pool, static_cast<std::size_t>(strains.rows()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = begin; i < end; ++i) {
                   const auto t = static_cast<Index>(i);
                   result.row(t) = (body.of_tet(t) * strains.row(t).transpose()).transpose();
                 }
               });
  return result;
}

}  // namespace s3
