#include "scalar_field/field_operators.h"

#include <algorithm>

namespace s3 {

namespace {

constexpr std::size_t kGrain = 4096;
constexpr std::size_t kRowGrain = 16384;  // each chunk of rows has an array of the mesh's size

// One row of a matrix under construction: values by column, without a search.
class RowBuilder {
 public:
  explicit RowBuilder(Index columns) : slot_(static_cast<std::size_t>(columns), -1) {}

  void add(Index column, double value) {
    if (slot_[column] < 0) {
      slot_[column] = static_cast<Index>(entries_.size());
      entries_.push_back({column, 0});
    }
    entries_[slot_[column]].second += value;
  }

  // Appends the row in column order and starts the next.
  void finish(std::vector<Index>& columns, std::vector<double>& values) {
    std::sort(entries_.begin(), entries_.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [column, value] : entries_) {
      columns.push_back(column);
      values.push_back(value);
      slot_[column] = -1;
    }
    entries_.clear();
  }

 private:
  std::vector<Index> slot_;
  std::vector<std::pair<Index, double>> entries_;
};

struct RowChunk {
  std::vector<Index> columns, row_sizes;
  std::vector<double> values;
};

SparseMatrix join_rows(const std::vector<RowChunk>& chunks, Index rows) {
  SparseMatrix A(rows, rows);
  std::size_t entries = 0;
  for (const RowChunk& c : chunks) entries += c.columns.size();
  A.resizeNonZeros(static_cast<Eigen::Index>(entries));
  Index row = 0, at = 0;
  A.outerIndexPtr()[0] = 0;
  for (const RowChunk& c : chunks) {
    std::copy(c.columns.begin(), c.columns.end(), A.innerIndexPtr() + at);
    std::copy(c.values.begin(), c.values.end(), A.valuePtr() + at);
    for (const Index size : c.row_sizes) {
      at += size;
      A.outerIndexPtr()[++row] = at;
    }
  }
  return A;
}

}  // namespace

FieldOperators::FieldOperators(const TetMesh& rest, Context& ctx)
    : rest_(rest),
      hat_(3 * rest.tets.rows(), 3),
      volume_(rest.tets.rows()),
      face_weight_(rest.face_pairs.rows()),
      face_normal_(rest.face_pairs.rows(), 3) {
  parallel_for(ctx.pool, static_cast<std::size_t>(rest.tet_count()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t) {
                   volume_(t) = tet_volume(rest.vertices, rest.tets, t);
                   const Eigen::Matrix<double, 3, 4> g = hat_gradients(rest, t);
                   for (int i = 1; i < 4; ++i)
                     hat_.row(3 * static_cast<Eigen::Index>(t) + i - 1) = g.col(i);
                 }
               });
  pair_across_.setConstant(rest.tet_count(), 4, -1);
  for (Index p = 0; p < rest.face_pairs.rows(); ++p) {
    const Index first = rest.face_pairs(p, 0), second = rest.face_pairs(p, 1);
    const int f = rest.face_pair_local(p, 0);
    pair_across_(first, f) = pair_across_(second, rest.face_pair_local(p, 1)) = p;
    // A hat gradient points away from the face opposite its corner.
    const Vec3 inward =
        f > 0 ? hat(first, f) : Vec3(-(hat(first, 1) + hat(first, 2) + hat(first, 3)));
    face_normal_.row(p) = -inward.normalized();
    face_weight_(p) = 0.25 * (volume_(first) + volume_(second));
  }
  corner_begin_.assign(static_cast<std::size_t>(rest.vertex_count()) + 1, 0);
  for (Index t = 0; t < rest.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) ++corner_begin_[rest.tets(t, i) + 1];
  for (Index v = 0; v < rest.vertex_count(); ++v) corner_begin_[v + 1] += corner_begin_[v];
  std::vector<Index> next(corner_begin_.begin(), corner_begin_.end() - 1);
  corners_.resize(4 * static_cast<std::size_t>(rest.tet_count()));
  for (Index t = 0; t < rest.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) corners_[next[rest.tets(t, i)]++] = 4 * t + i;
}

void FieldOperators::gradients(const Values& value, Points& gradient_of, Context& ctx) const {
  gradient_of.resize(rest_.tets.rows(), 3);
  parallel_for(ctx.pool, static_cast<std::size_t>(rest_.tet_count()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t)
                   gradient_of.row(t) = gradient(value, t);
               });
}

void FieldOperators::adjoint(const Points& tet_vector, Values& vertex_sum, Context& ctx) const {
  std::vector<double> corner_value(4 * static_cast<std::size_t>(rest_.tet_count()));
  parallel_for(ctx.pool, static_cast<std::size_t>(rest_.tet_count()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t t = begin; t < end; ++t) {
                   const Vec3 x = tet_vector.row(static_cast<Eigen::Index>(t));
                   double sum = 0;
                   for (int i = 1; i < 4; ++i) {
                     corner_value[4 * t + i] = hat(static_cast<Index>(t), i).dot(x);
                     sum += corner_value[4 * t + i];
                   }
                   corner_value[4 * t] = -sum;
                 }
               });
  vertex_sum.resize(rest_.vertices.rows());
  parallel_for(ctx.pool, static_cast<std::size_t>(rest_.vertex_count()), kGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v) {
                   double sum = 0;
                   for (Index c = corner_begin_[v]; c < corner_begin_[v + 1]; ++c)
                     sum += corner_value[corners_[c]];
                   vertex_sum(static_cast<Eigen::Index>(v)) = sum;
                 }
               });
}

SparseMatrix FieldOperators::energy(const Values& tet_weight, const Values& pair_weight,
                                    const std::vector<Index>& free_index, Context& ctx) const {
  std::vector<Index> vertex_of_row;
  for (Index v = 0; v < rest_.vertex_count(); ++v)
    if (free_index[v] >= 0) vertex_of_row.push_back(v);
  const auto rows = static_cast<Index>(vertex_of_row.size());

  const auto hats = [&](Index t) {
    Eigen::Matrix<double, 3, 4> g;
    for (int i = 1; i < 4; ++i) g.col(i) = hat(t, i);
    g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
    return g;
  };
  const auto add_tet = [&](RowBuilder& row, Index t, int i) {
    const Eigen::Matrix<double, 3, 4> g = hats(t);
    const Vec3 scaled = tet_weight(t) * g.col(i);
    for (int j = 0; j < 4; ++j) {
      const Index column = free_index[rest_.tets(t, j)];
      if (column >= 0) row.add(column, scaled.dot(g.col(j)));
    }
  };
  // The jump is Σ c_k G_k over the corners of both tets; the shared corners appear twice and add
  // up.
  const auto add_pair = [&](RowBuilder& row, Index p, Index v) {
    const Vec3 n = face_normal(p);
    std::array<Index, 8> corner;
    std::array<double, 8> c;
    double own = 0;
    for (int side = 0; side < 2; ++side) {
      const Index t = rest_.face_pairs(p, side);
      const Eigen::Matrix<double, 3, 4> g = hats(t);
      for (int i = 0; i < 4; ++i) {
        corner[4 * side + i] = rest_.tets(t, i);
        c[4 * side + i] = (side == 0 ? -1 : 1) * g.col(i).dot(n);
        if (rest_.tets(t, i) == v) own += c[4 * side + i];
      }
    }
    for (int k = 0; k < 8; ++k) {
      const Index column = free_index[corner[k]];
      if (column >= 0) row.add(column, pair_weight(p) * own * c[k]);
    }
  };
  const bool with_pairs = pair_weight.size() > 0;
  std::vector<RowChunk> chunks((static_cast<std::size_t>(rows) + kRowGrain - 1) / kRowGrain);
  parallel_for(ctx.pool, static_cast<std::size_t>(rows), kRowGrain,
               [&](std::size_t begin, std::size_t end) {
                 RowChunk& chunk = chunks[begin / kRowGrain];
                 RowBuilder row(rows);
                 for (std::size_t r = begin; r < end; ++r) {
                   const Index v = vertex_of_row[r];
                   for (Index c = corner_begin_[v]; c < corner_begin_[v + 1]; ++c) {
                     const Index t = corners_[c] / 4;
                     const int i = corners_[c] % 4;
                     add_tet(row, t, i);
                     for (int f = 0; with_pairs && f < 4; ++f) {
                       const Index p = pair_across_(t, f);
                       // Both tets of a face through v come by here; the first one does the work.
                       if (p >= 0 && (f == i || rest_.face_pairs(p, 0) == t)) add_pair(row, p, v);
                     }
                   }
                   const std::size_t before = chunk.columns.size();
                   row.finish(chunk.columns, chunk.values);
                   chunk.row_sizes.push_back(static_cast<Index>(chunk.columns.size() - before));
                 }
               });
  return join_rows(chunks, rows);
}

void Anchors::gather_free(const Values& vertex_values, Block& rows) const {
  for (std::size_t v = 0; v < free_index.size(); ++v)
    if (free_index[v] >= 0) rows(free_index[v], 0) = vertex_values(static_cast<Eigen::Index>(v));
}

void Anchors::add_free(const Block& rows, Values& vertex_values) const {
  for (std::size_t v = 0; v < free_index.size(); ++v)
    if (free_index[v] >= 0) vertex_values(static_cast<Eigen::Index>(v)) += rows(free_index[v], 0);
}

Anchors find_anchors(const TetMesh& rest, const ObjectiveField& objectives) {
  const Index n = rest.vertex_count();
  Anchors anchors;
  anchors.planar = rest.vertices.col(2).array() - rest.vertices.col(2).minCoeff();

  // Components by union-find over the tets' vertices.
  std::vector<Index> parent(static_cast<std::size_t>(n));
  for (Index v = 0; v < n; ++v) parent[v] = v;
  const auto find = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<char> used(static_cast<std::size_t>(n), 0);
  for (Index t = 0; t < rest.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) {
      used[rest.tets(t, i)] = 1;
      parent[find(rest.tets(t, i))] = find(rest.tets(t, 0));
    }
  std::vector<char> fixed(static_cast<std::size_t>(n), 0), held(static_cast<std::size_t>(n), 0);
  std::vector<Index> lowest(static_cast<std::size_t>(n), -1);
  for (Index v = 0; v < n; ++v) {
    fixed[v] = !used[v] || objectives.vertex_on_plate[v];  // a vertex without tets has no equation
    const Index root = find(v);
    held[root] |= used[v] && objectives.vertex_on_plate[v];
    if (lowest[root] < 0 || rest.vertices(v, 2) < rest.vertices(lowest[root], 2)) lowest[root] = v;
  }
  for (Index v = 0; v < n; ++v)
    if (find(v) == v && !held[v]) fixed[lowest[v]] = 1;

  anchors.free_index.assign(static_cast<std::size_t>(n), -1);
  for (Index v = 0; v < n; ++v)
    if (!fixed[v]) anchors.free_index[v] = anchors.free_count++;
  return anchors;
}

}  // namespace s3
