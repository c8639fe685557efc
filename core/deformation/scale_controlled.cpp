// Sec. 4.1, Eq. 12 as one symmetric positive definite system in positions X and scales s. Per tet,
// with the centred rest corners P = N V_e / h (rows p_i) and the rotation R,
//   a ‖N X − P S Rᵀ‖² + w_r m ‖S − I‖²,   and over each face pair   w_c w ‖S_i − S_j‖²,
// gives   a (N X − P S Rᵀ)   and   a (Σ_i p_i² ∘ s − Σ_i p_i ∘ Rᵀ x_i) + w_r m (s − 1) + w_c Σ w (s
// − s_j)   as gradient. Position and scale blocks do not depend on R, so their multigrid
// hierarchies serve all outer iterations as preconditioner.
#include "deformation/scale_controlled.h"

#include <algorithm>
#include <cmath>

#include "math/multigrid.h"
#include "quaternion_field/face_laplacian.h"

namespace s3 {

namespace {

// The resolution at which w_c means what the paper's value does: its models have 25k to 250k tets.
constexpr double kReferenceTets = 50000;
constexpr std::size_t kGrain = 2048;

// Positions and scales; one search direction, residual or solution of the joint system.
struct State {
  Points x;  // #V×3, in mean edges, relative to the component's held vertex
  Points s;  // #T×3
};

double dot(const State& a, const State& b) {
  return a.x.cwiseProduct(b.x).sum() + a.s.cwiseProduct(b.s).sum();
}

// The tets around each vertex, as offsets into (tet, corner) pairs packed as 4 t + i.
struct VertexTets {
  std::vector<Index> begin, corner;
};

VertexTets vertex_tets(const TetMesh& mesh) {
  VertexTets around;
  around.begin.assign(static_cast<std::size_t>(mesh.vertex_count()) + 1, 0);
  for (Index t = 0; t < mesh.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) ++around.begin[mesh.tets(t, i) + 1];
  for (std::size_t v = 1; v < around.begin.size(); ++v) around.begin[v] += around.begin[v - 1];
  around.corner.resize(4 * static_cast<std::size_t>(mesh.tet_count()));
  std::vector<Index> next(around.begin.begin(), around.begin.end() - 1);
  for (Index t = 0; t < mesh.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) around.corner[next[mesh.tets(t, i)]++] = 4 * t + i;
  return around;
}

// The lowest vertex index of each vertex's component.
std::vector<Index> component_roots(const TetMesh& mesh) {
  std::vector<Index> parent(static_cast<std::size_t>(mesh.vertex_count()));
  for (Index v = 0; v < mesh.vertex_count(); ++v) parent[v] = v;
  const auto root = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (Index t = 0; t < mesh.tet_count(); ++t)
    for (int i = 1; i < 4; ++i) {
      const Index a = root(mesh.tets(t, 0)), b = root(mesh.tets(t, i));
      parent[std::max(a, b)] = std::min(a, b);
    }
  for (Index v = 0; v < mesh.vertex_count(); ++v) parent[v] = root(v);
  return parent;
}

// Which coordinates stay, and where: value `origin` of the vertex.
struct Supports {
  std::vector<char> fixed_xy, fixed_z;  // #V
  Points origin;                        // #V×3 mm, one value for each component
};

Supports make_supports(const TetMesh& rest, const std::vector<char>& on_plate) {
  const std::vector<Index> root = component_roots(rest);
  // A component is held by its first vertex on the plate, or else by its lowest one.
  std::vector<Index> held(root.size(), -1);
  const auto better = [&](Index v, Index w) {
    if (on_plate[v] != on_plate[w]) return on_plate[v] != 0;
    return !on_plate[v] && rest.vertices(v, 2) < rest.vertices(w, 2);
  };
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    Index& best = held[root[v]];
    if (best < 0 || better(v, best)) best = v;
  }
  Supports supports{std::vector<char>(root.size(), 0), on_plate, Points(rest.vertex_count(), 3)};
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    const Index h = held[root[v]];
    supports.origin.row(v) = rest.vertices.row(h);
    if (on_plate[h]) supports.origin(v, 2) = 0;
    if (v == h) supports.fixed_xy[v] = supports.fixed_z[v] = 1;
  }
  return supports;
}

// Σ_e a_e N over the corners: a graph Laplacian. Rows of fixed vertices keep their diagonal only.
SparseMatrix position_matrix(const TetMesh& rest, const VertexTets& around, const Values& a,
                             const std::vector<char>& fixed) {
  SparseMatrix A(rest.vertex_count(), rest.vertex_count());
  std::vector<Index> begin(1, 0), column;
  std::vector<double> value;
  std::vector<std::pair<Index, double>> entries;
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    entries.clear();
    double diagonal = 0;
    for (Index k = around.begin[v]; k < around.begin[v + 1]; ++k) {
      const Index t = around.corner[k] / 4;
      diagonal += 0.75 * a(t);
      for (int j = 0; j < 4; ++j) {
        const Index w = rest.tets(t, j);
        if (w != v && !fixed[v] && !fixed[w]) entries.emplace_back(w, -0.25 * a(t));
      }
    }
    entries.emplace_back(v, diagonal > 0 ? diagonal : 1.0);  // an unused vertex stays
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& p, const auto& q) { return p.first < q.first; });
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (i > 0 && entries[i].first == entries[i - 1].first) {
        value.back() += entries[i].second;
        continue;
      }
      column.push_back(entries[i].first);
      value.push_back(entries[i].second);
    }
    begin.push_back(static_cast<Index>(column.size()));
  }
  return Eigen::Map<const SparseMatrix>(rest.vertex_count(), rest.vertex_count(),
                                        static_cast<Index>(column.size()), begin.data(),
                                        column.data(), value.data());
}

}  // namespace

struct ScaleControlledDeformer::System {
  const TetMesh& rest;
  ScaleControlParams params;
  double unit;  // mean edge, mm
  VertexTets around;
  Supports supports;
  Values position_weight;        // #T, a
  Values rigidity_weight;        // #T, w_r m
  SparseMatrix laplacian;        // #V, Σ a N without any support
  SparseMatrix scale_smoothing;  // #T, w_c times the weighted face-adjacency Laplacian
  Points scale_diagonal;         // #T×3, a Σ_i p_i² + w_r m
  Multigrid xy, z, scale;

  System(const TetMesh& rest, const std::vector<char>& on_plate, const ScaleControlParams& params,
         Context& ctx);

  // p_i of a tet.
  Vec3 centred(Index t, const Vec3& centre, int i) const {
    return (rest.corner(t, i) - centre) / unit;
  }

  void weigh_tets();
  void build_scale_smoothing();
  void release_fixed(Points& x) const;
  void apply(const std::vector<Mat3>& rotation, const State& in, State& out, Context& ctx) const;
  void precondition(const State& r, State& out, Context& ctx) const;
  int solve(const std::vector<Mat3>& rotation, State& state, bool& converged, Context& ctx) const;

  mutable std::vector<float> r_float, z_float;  // scratch of precondition()
};

ScaleControlledDeformer::System::System(const TetMesh& rest, const std::vector<char>& on_plate,
                                        const ScaleControlParams& params, Context& ctx)
    : rest(rest),
      params(params),
      unit(mean_edge_length(rest)),
      around(vertex_tets(rest)),
      supports(make_supports(rest, on_plate)) {
  weigh_tets();
  build_scale_smoothing();
  const std::vector<char> none(on_plate.size(), 0);
  laplacian = position_matrix(rest, around, position_weight, none);
  ctx.checkpoint();
  xy.build(position_matrix(rest, around, position_weight, supports.fixed_xy), {}, 1, ctx);
  z.build(position_matrix(rest, around, position_weight, supports.fixed_z), {}, 1, ctx);
  // One hierarchy for the three scales: their diagonals differ by the tet's shape only.
  SparseMatrix scale_block = scale_smoothing;
  scale_block.diagonal() += scale_diagonal.rowwise().mean();
  scale.build(scale_block, {}, 1, ctx);
  const auto largest = std::max(rest.vertex_count(), rest.tet_count());
  r_float.resize(3 * static_cast<std::size_t>(largest));
  z_float.resize(r_float.size());
}

void ScaleControlledDeformer::System::weigh_tets() {
  const Values volume = tet_volumes(rest);
  const Values share = volume / volume.mean();
  // ‖N X − P S Rᵀ‖² grows with the square of the tet's edges, so volume^⅓ is left of the volume.
  position_weight = share.array().pow(1.0 / 3.0);
  rigidity_weight = params.rigidity * share;
  scale_diagonal.resize(rest.tet_count(), 3);
  for (Index t = 0; t < rest.tet_count(); ++t) {
    const Vec3 centre = rest.centroid(t);
    Vec3 square = Vec3::Zero();
    for (int i = 0; i < 4; ++i) square += centred(t, centre, i).cwiseAbs2();
    scale_diagonal.row(t) = position_weight(t) * square.array() + rigidity_weight(t);
  }
}

void ScaleControlledDeformer::System::build_scale_smoothing() {
  const double resolution = std::pow(rest.tet_count() / kReferenceTets, 2.0 / 3.0);
  Values weight(rest.face_pairs.rows());
  for (Index p = 0; p < weight.size(); ++p)
    weight(p) =
        params.scale_compatibility * resolution *
        std::sqrt(position_weight(rest.face_pairs(p, 0)) * position_weight(rest.face_pairs(p, 1)));
  scale_smoothing = face_laplacian(rest, weight, Values::Zero(rest.tet_count()));
}

// Fixed coordinates carry no residual and never move.
void ScaleControlledDeformer::System::release_fixed(Points& x) const {
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    if (supports.fixed_xy[v]) x(v, 0) = x(v, 1) = 0;
    if (supports.fixed_z[v]) x(v, 2) = 0;
  }
}

void ScaleControlledDeformer::System::apply(const std::vector<Mat3>& rotation, const State& in,
                                            State& out, Context& ctx) const {
  const auto vertices = static_cast<std::size_t>(rest.vertex_count());
  parallel_for(ctx.pool, vertices, kGrain, [&](std::size_t begin, std::size_t end) {
    for (auto v = static_cast<Index>(begin); v < static_cast<Index>(end); ++v) {
      Vec3 sum = Vec3::Zero();
      for (SparseMatrix::InnerIterator it(laplacian, v); it; ++it)
        sum += it.value() * in.x.row(it.col()).transpose();
      for (Index k = around.begin[v]; k < around.begin[v + 1]; ++k) {
        const Index t = around.corner[k] / 4;
        const Vec3 p = centred(t, rest.centroid(t), around.corner[k] % 4);
        sum -= position_weight(t) * (rotation[t] * p.cwiseProduct(in.s.row(t).transpose()));
      }
      out.x.row(v) = sum;
    }
  });
  release_fixed(out.x);
  const auto tets = static_cast<std::size_t>(rest.tet_count());
  parallel_for(ctx.pool, tets, kGrain, [&](std::size_t begin, std::size_t end) {
    for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t) {
      Vec3 sum = scale_diagonal.row(t).cwiseProduct(in.s.row(t));
      for (SparseMatrix::InnerIterator it(scale_smoothing, t); it; ++it)
        sum += it.value() * in.s.row(it.col()).transpose();
      const Vec3 centre = rest.centroid(t);
      Vec3 coupling = Vec3::Zero();
      for (int i = 0; i < 4; ++i) {
        const Vec3 x = in.x.row(rest.tets(t, i));
        coupling += centred(t, centre, i).cwiseProduct(rotation[t].transpose() * x);
      }
      out.s.row(t) = sum - position_weight(t) * coupling;
    }
  });
}

void ScaleControlledDeformer::System::precondition(const State& r, State& out, Context& ctx) const {
  using Floats = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto block = [&](const Multigrid& grid, const auto& from, auto&& to) {
    const int columns = static_cast<int>(from.cols());
    Eigen::Map<Floats>(r_float.data(), from.rows(), columns) = from.template cast<float>();
    grid.apply(r_float.data(), z_float.data(), columns, ctx.pool);
    to = Eigen::Map<const Floats>(z_float.data(), from.rows(), columns).template cast<double>();
  };
  block(xy, r.x.leftCols<2>(), out.x.leftCols<2>());
  block(z, r.x.rightCols<1>(), out.x.rightCols<1>());
  block(scale, r.s.leftCols<3>(), out.s.leftCols<3>());
  release_fixed(out.x);
}

// Preconditioned conjugate gradients on the joint system, warm-started. The right-hand side is w_r
// m for the scales and zero for the positions.
int ScaleControlledDeformer::System::solve(const std::vector<Mat3>& rotation, State& state,
                                           bool& converged, Context& ctx) const {
  State r = state, z = state, p, q = state;
  apply(rotation, state, r, ctx);
  r.x *= -1;
  r.s = rigidity_weight.replicate(1, 3) - r.s;
  const double target = params.tolerance * std::sqrt(3.0) * rigidity_weight.norm();
  double rho = 0;
  for (int iteration = 0; iteration < params.max_iterations; ++iteration) {
    converged = std::sqrt(dot(r, r)) <= target;
    if (converged) return iteration;
    ctx.checkpoint();
    precondition(r, z, ctx);
    const double rho_new = dot(r, z);
    if (iteration == 0) {
      p = z;
    } else {
      const double beta = rho_new / rho;
      p.x = z.x + beta * p.x;
      p.s = z.s + beta * p.s;
    }
    rho = rho_new;
    apply(rotation, p, q, ctx);
    const double step = rho / dot(p, q);
    state.x += step * p.x;
    state.s += step * p.s;
    r.x -= step * q.x;
    r.s -= step * q.s;
  }
  return params.max_iterations;
}

Deformation undeformed(const TetMesh& rest) {
  return {rest.vertices, Points::Ones(rest.tet_count(), 3)};
}

ScaleControlledDeformer::ScaleControlledDeformer(const TetMesh& rest,
                                                 const std::vector<char>& vertex_on_plate,
                                                 const ScaleControlParams& params, Context& ctx)
    : system_(std::make_unique<System>(rest, vertex_on_plate, params, ctx)) {}

ScaleControlledDeformer::~ScaleControlledDeformer() = default;

Deformation ScaleControlledDeformer::deform(const Quats& rotation, const Deformation& start,
                                            Context& ctx) const {
  const System& system = *system_;
  std::vector<Mat3> matrices(static_cast<std::size_t>(rotation.rows()));
  for (Index t = 0; t < rotation.rows(); ++t)
    matrices[t] =
        Quat(rotation(t, 3), rotation(t, 0), rotation(t, 1), rotation(t, 2)).toRotationMatrix();
  State state{(start.vertices - system.supports.origin) / system.unit, start.scales};
  system.release_fixed(state.x);
  Deformation result;
  result.iterations = system.solve(matrices, state, result.converged, ctx);
  result.vertices = system.unit * state.x + system.supports.origin;
  result.scales = std::move(state.s);
  return result;
}

}  // namespace s3
