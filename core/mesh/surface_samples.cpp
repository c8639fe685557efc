#include "mesh/surface_samples.h"

#include <cmath>

namespace s3 {

Points sample_surface(const TriMesh& surface, double count, std::vector<Index>* triangles) {
  const double spacing_area = surface_area(surface) / count;
  std::vector<Vec3> points;
  if (triangles) triangles->clear();
  double due = 0.5;  // samples owed: carries the remainders from triangle to triangle
  double u = 0.5, v = 0.5;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corner = [&](int k) -> Vec3 {
      return surface.vertices.row(surface.triangles(f, k));
    };
    due += triangle_normal_2a(surface.vertices, surface.triangles.row(f)).norm() / 2 / spacing_area;
    for (; due >= 1; due -= 1) {
      u = std::fmod(u + 0.7548776662466927, 1.0);  // the R2 sequence (M. Roberts 2018)
      v = std::fmod(v + 0.5698402909980532, 1.0);
      const double a = u + v > 1 ? 1 - u : u, b = u + v > 1 ? 1 - v : v;
      points.push_back((1 - a - b) * corner(0) + a * corner(1) + b * corner(2));
      if (triangles) triangles->push_back(static_cast<Index>(f));
    }
  }
  Points rows(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = points[i];
  return rows;
}

}  // namespace s3
