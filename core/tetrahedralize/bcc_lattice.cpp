#include "tetrahedralize/bcc_lattice.h"

#include <cmath>

#include "base/error.h"

namespace s3 {

namespace {

constexpr double kMaxVertices = 1e8;
constexpr double kMargin = 2;
const Vec3 kShift(0.3819660, 0.4142136, 0.2679492);

double corners_along(double extent, double size) {
  return std::floor(extent / size) + 2 * kMargin + 2;
}

double vertex_count(const Vec3& low, const Vec3& high, double size) {
  double count = 2;
  for (int k = 0; k < 3; ++k) count *= corners_along(high[k] - low[k], size);
  return count;
}

}  // namespace

int BccLattice::own_edges(Index v, std::array<Index, 11>& others) const {
  const Place p = place(v);
  int n = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    Place q = p;
    ++q.cell[k];
    if (contains(q)) others[static_cast<std::size_t>(n++)] = index(q);
  }
  if (p.kind == 1) return n;
  for (Index corner = 0; corner < 8; ++corner) {
    const Place q{
        {p.cell[0] - (corner & 1), p.cell[1] - (corner >> 1 & 1), p.cell[2] - (corner >> 2)}, 1};
    if (contains(q)) others[static_cast<std::size_t>(n++)] = index(q);
  }
  return n;
}

int BccLattice::own_tets(Index center, std::array<std::array<Index, 4>, 12>& tets) const {
  const Place p = place(center);
  int n = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Place next = p;
    ++next.cell[axis];
    if (!contains(next)) continue;
    // The four corners of the face between both cubes, around it.
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<Index, 4> ring;
    bool inside = true;
    for (std::size_t i = 0; i < 4; ++i) {
      Place q{next.cell, 0};
      q.cell[u] += i == 1 || i == 2;
      q.cell[v] += i >= 2;
      inside = inside && contains(q);
      ring[i] = inside ? index(q) : 0;
    }
    if (!inside) continue;
    for (std::size_t i = 0; i < 4; ++i)
      tets[static_cast<std::size_t>(n++)] = {center, index(next), ring[i], ring[(i + 1) % 4]};
  }
  return n;
}

BccLattice lattice_around(const Vec3& low, const Vec3& high, double size) {
  if (!(vertex_count(low, high, size) <= kMaxVertices))
    throw Error(
        ErrorKind::slicing, Stage::tetrahedralize, "tetrahedralize.too_thin",
        "The model fills too little of its bounding box to be meshed by isosurface stuffing "
        "at this size of tets",
        "Ask for fewer tets with mesh.target_tets, or give the model thicker walls");
  BccLattice lattice;
  lattice.size = size;
  lattice.origin = low - size * (Vec3::Constant(kMargin) - kShift);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    lattice.counts[k] = static_cast<Index>(corners_along(high[axis] - low[axis], size));
  }
  return lattice;
}

double smallest_lattice_size(const Vec3& low, const Vec3& high) {
  // The count falls with the size: bisection to a tenth of a percent.
  double small = 0, large = (high - low).maxCoeff();
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (small + large);
    (middle > 0 && vertex_count(low, high, middle) <= kMaxVertices ? large : small) = middle;
  }
  return large * 1.001;
}

}  // namespace s3
