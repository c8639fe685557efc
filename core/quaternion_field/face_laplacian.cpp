#include "quaternion_field/face_laplacian.h"

#include <array>

namespace s3 {

namespace {

struct Entry {
  Index column;
  double value;
};

// A row's entries in ascending columns: the tet itself and up to four neighbours.
struct Row {
  std::array<Entry, 5> entries;
  int count = 0;

  void insert(Index column, double value) {
    int i = count++;
    for (; i > 0 && entries[i - 1].column > column; --i) entries[i] = entries[i - 1];
    entries[i] = {column, value};
  }
};

}  // namespace

SparseMatrix face_laplacian(const TetMesh& mesh, const Values& weight, const Values& diagonal) {
  const Index n = mesh.tet_count();
  Tets pair_across(n, 4);  // the face pair behind each face
  for (Index p = 0; p < mesh.face_pairs.rows(); ++p)
    for (int side = 0; side < 2; ++side)
      pair_across(mesh.face_pairs(p, side), mesh.face_pair_local(p, side)) = p;

  SparseMatrix A(n, n);
  A.resizeNonZeros(n + 2 * mesh.face_pairs.rows());
  Index fill = 0;
  for (Index t = 0; t < n; ++t) {
    A.outerIndexPtr()[t] = fill;
    Row row;
    double sum = diagonal(t);
    for (int f = 0; f < 4; ++f) {
      const Index other = mesh.neighbors(t, f);
      if (other < 0) continue;
      const double w = weight(pair_across(t, f));
      row.insert(other, -w);
      sum += w;
    }
    row.insert(t, sum);
    for (int i = 0; i < row.count; ++i, ++fill) {
      A.innerIndexPtr()[fill] = row.entries[i].column;
      A.valuePtr()[fill] = row.entries[i].value;
    }
  }
  A.outerIndexPtr()[n] = fill;
  return A;
}

}  // namespace s3
