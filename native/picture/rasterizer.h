// A small software renderer: triangles and lines into an image, no graphics hardware needed.
#pragma once
#include <string>
#include <vector>

#include "base/types.h"

namespace s3 {

using Color = Eigen::Vector3f;  // linear 0…1

/// An orthographic view. `right`, `up` and `toward` (to the viewer) are orthonormal.
struct Camera {
  Vec3 center = Vec3::Zero();
  Vec3 right = Vec3::UnitX(), up = Vec3::UnitZ(), toward = -Vec3::UnitY();
  double half_height = 1;  // mm from the middle of the picture to its upper edge

  /// @param azimuth, elevation  rad; azimuth 0 looks along +y (from the front)
  static Camera orbit(const Vec3& center, double azimuth, double elevation, double half_height);
};

/// 8-bit RGB, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<unsigned char> rgb;

  Image(int w, int h)
      : width(w),
        height(h),
        rgb(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 3, 255) {}
  void paste(const Image& part, int x, int y);
};

/// Writes a PNG under a temporary name and renames it.
/// @throws Error "picture.write"
void write_png(const Image& image, const std::string& path);

/// Draws into a depth buffer with 2×2 samples a pixel.
class Rasterizer {
 public:
  Rasterizer(int width, int height, const Camera& camera);

  /// A triangle with one normal a corner; lit from both sides.
  void triangle(const Vec3 corners[3], const Vec3 normals[3], const Color colors[3]);
  void line(const Vec3& a, const Vec3& b, const Color& color, double width_px);

  /// The picture with contours darkened where the depth jumps.
  Image finish() const;

 private:
  Vec3 project(const Vec3& p) const;  // x, y in samples, z toward the viewer in mm
  void plot(int x, int y, double depth, const Color& color);

  int width_, height_;  // in samples
  Camera camera_;
  double samples_per_mm_;
  std::vector<float> depth_;
  std::vector<Color> color_;
};

}  // namespace s3
