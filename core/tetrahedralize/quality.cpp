#include "tetrahedralize/quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/units.h"

namespace s3 {

namespace {
constexpr std::size_t kWorstPlaces = 10;
}

DihedralRange dihedral_range(const TetMesh& mesh, Index t) {
  std::array<Vec3, 4> normals;
  for (int f = 0; f < 4; ++f) {
    const Vec3 a = mesh.corner(t, kTetFaces[f][0]), b = mesh.corner(t, kTetFaces[f][1]),
               c = mesh.corner(t, kTetFaces[f][2]);
    normals[static_cast<std::size_t>(f)] = (b - a).cross(c - a).normalized();
  }
  DihedralRange range{kPi, 0};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      // The angle inside the tet is π minus the angle between the outward normals.
      const double angle =
          kPi - std::atan2(normals[i].cross(normals[j]).norm(), normals[i].dot(normals[j]));
      range.min = std::min(range.min, angle);
      range.max = std::max(range.max, angle);
    }
  return range;
}

double least_sine(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // sin θ of edge ij = 3/2 V l_ij / (A_k A_l), A the areas of the faces that meet in it.
  const Vec3 ab = b - a, ac = c - a, ad = d - a, bc = c - b, bd = d - b;
  const double six_volume = ab.dot(ac.cross(ad));
  // Squares of twice the areas opposite to a, b, c, d.
  const double fa = bc.cross(bd).squaredNorm(), fb = ac.cross(ad).squaredNorm(),
               fc = ab.cross(ad).squaredNorm(), fd = ab.cross(ac).squaredNorm();
  const double least2 = std::min({ab.squaredNorm() / (fc * fd), ac.squaredNorm() / (fb * fd),
                                  ad.squaredNorm() / (fb * fc), bc.squaredNorm() / (fa * fd),
                                  bd.squaredNorm() / (fa * fc), (d - c).squaredNorm() / (fa * fb)});
  if (!(least2 < std::numeric_limits<double>::infinity())) return -1;
  return six_volume * std::sqrt(least2);
}

TetQuality tet_quality(const TetMesh& mesh) {
  TetQuality quality;
  const Index n = mesh.tet_count();
  if (n == 0) return quality;
  quality.min_dihedral = kPi;
  quality.min_volume = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, Index>> angles(static_cast<std::size_t>(n));
  double sum = 0;
  for (Index t = 0; t < n; ++t) {
    const DihedralRange range = dihedral_range(mesh, t);
    angles[static_cast<std::size_t>(t)] = {range.min, t};
    sum += range.min;
    quality.min_dihedral = std::min(quality.min_dihedral, range.min);
    quality.max_dihedral = std::max(quality.max_dihedral, range.max);
    if (range.min < radians(10)) ++quality.tets_below_10_deg;
    const double volume = tet_volume(mesh.vertices, mesh.tets, t);
    quality.min_volume = std::min(quality.min_volume, volume);
    quality.max_volume = std::max(quality.max_volume, volume);
  }
  quality.mean_min_dihedral = sum / n;
  const auto worst =
      angles.begin() + static_cast<std::ptrdiff_t>(std::min(kWorstPlaces, angles.size()));
  std::partial_sort(angles.begin(), worst, angles.end());
  for (auto it = angles.begin(); it != worst; ++it)
    quality.worst_places.push_back(mesh.centroid(it->second));
  return quality;
}

}  // namespace s3
