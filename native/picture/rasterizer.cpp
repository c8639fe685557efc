#include "picture/rasterizer.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "base/error.h"

namespace s3 {

namespace {

constexpr int kSamples = 2;  // a side
constexpr float kFarAway = -std::numeric_limits<float>::max();

// Key light over the viewer's left shoulder, fill from the right, and a floor of ambient light.
Color shade(const Color& color, const Vec3& normal, const Camera& camera) {
  Vec3 n = normal.normalized();
  if (n.dot(camera.toward) < 0) n = -n;
  const Vec3 key = (camera.toward + 0.6 * camera.up - 0.5 * camera.right).normalized();
  const Vec3 fill = (0.6 * camera.toward + 0.2 * camera.up + camera.right).normalized();
  const double light = 0.28 + 0.62 * std::max(0.0, n.dot(key)) + 0.18 * std::max(0.0, n.dot(fill));
  return (color * static_cast<float>(light)).cwiseMin(1.0F);
}

unsigned char to_srgb(float linear) {
  return static_cast<unsigned char>(
      std::lround(255.0F * std::pow(std::clamp(linear, 0.0F, 1.0F), 1.0F / 2.2F)));
}

}  // namespace

Camera Camera::orbit(const Vec3& center, double azimuth, double elevation, double half_height) {
  Camera camera;
  camera.center = center;
  camera.half_height = half_height;
  camera.toward = Vec3(std::sin(azimuth) * std::cos(elevation),
                       -std::cos(azimuth) * std::cos(elevation), std::sin(elevation));
  camera.right = Vec3(std::cos(azimuth), std::sin(azimuth), 0);
  camera.up = camera.toward.cross(camera.right);
  return camera;
}

void Image::paste(const Image& part, int x, int y) {
  for (int row = 0; row < part.height; ++row)
    std::copy_n(part.rgb.begin() + static_cast<std::ptrdiff_t>(row) * part.width * 3,
                part.width * 3,
                rgb.begin() + (static_cast<std::ptrdiff_t>(y + row) * width + x) * 3);
}

void write_png(const Image& image, const std::string& path) {
  const std::string temporary = path + ".part";
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  const bool written =
      png_image_write_to_file(&header, temporary.c_str(), 0, image.rgb.data(), 0, nullptr) != 0;
  if (!written || std::rename(temporary.c_str(), path.c_str()) != 0)
    throw Error(ErrorKind::input, Stage::exporting, "picture.write", "Cannot write " + path,
                "Choose a folder that exists and can be written");
}

Rasterizer::Rasterizer(int width, int height, const Camera& camera)
    : width_(width * kSamples),
      height_(height * kSamples),
      camera_(camera),
      samples_per_mm_(0.5 * height_ / camera.half_height),
      depth_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kFarAway),
      color_(depth_.size(), Color::Ones()) {}

Vec3 Rasterizer::project(const Vec3& p) const {
  const Vec3 d = p - camera_.center;
  return {0.5 * width_ + samples_per_mm_ * d.dot(camera_.right),
          0.5 * height_ - samples_per_mm_ * d.dot(camera_.up), d.dot(camera_.toward)};
}

void Rasterizer::plot(int x, int y, double depth, const Color& color) {
  const auto i =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  if (static_cast<float>(depth) <= depth_[i]) return;
  depth_[i] = static_cast<float>(depth);
  color_[i] = color;
}

void Rasterizer::triangle(const Vec3 corners[3], const Vec3 normals[3], const Color colors[3]) {
  const Vec3 a = project(corners[0]), b = project(corners[1]), c = project(corners[2]);
  const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
  if (area == 0) return;
  const int x0 = std::max(0, static_cast<int>(std::floor(std::min({a.x(), b.x(), c.x()}))));
  const int x1 = std::min(width_ - 1, static_cast<int>(std::ceil(std::max({a.x(), b.x(), c.x()}))));
  const int y0 = std::max(0, static_cast<int>(std::floor(std::min({a.y(), b.y(), c.y()}))));
  const int y1 =
      std::min(height_ - 1, static_cast<int>(std::ceil(std::max({a.y(), b.y(), c.y()}))));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      const double wb = ((px - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (py - a.y())) / area;
      const double wc = ((b.x() - a.x()) * (py - a.y()) - (px - a.x()) * (b.y() - a.y())) / area;
      const double wa = 1 - wb - wc;
      if (wa < 0 || wb < 0 || wc < 0) continue;
      const Color color = colors[0] * static_cast<float>(wa) + colors[1] * static_cast<float>(wb) +
                          colors[2] * static_cast<float>(wc);
      plot(x, y, wa * a.z() + wb * b.z() + wc * c.z(),
           shade(color, wa * normals[0] + wb * normals[1] + wc * normals[2], camera_));
    }
}

void Rasterizer::line(const Vec3& a, const Vec3& b, const Color& color, double width_px) {
  const Vec3 p = project(a), q = project(b);
  const int steps = std::max(1, static_cast<int>(std::ceil((q - p).head<2>().norm())));
  const int radius = static_cast<int>(std::lround(0.5 * width_px * kSamples));
  const double lift = 1.5 / samples_per_mm_;  // drawn over the surface it lies on
  for (int s = 0; s <= steps; ++s) {
    const Vec3 m = p + (q - p) * (static_cast<double>(s) / steps);
    for (int dy = -radius; dy <= radius; ++dy)
      for (int dx = -radius; dx <= radius; ++dx) {
        const int x = static_cast<int>(m.x()) + dx, y = static_cast<int>(m.y()) + dy;
        if (x >= 0 && y >= 0 && x < width_ && y < height_) plot(x, y, m.z() + lift, color);
      }
  }
}

Image Rasterizer::finish() const {
  Image image(width_ / kSamples, height_ / kSamples);
  const double jump = 12 / samples_per_mm_;  // mm: a step in depth this large is a contour
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      Color sum = Color::Zero();
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const int sx = x * kSamples + s % kSamples, sy = y * kSamples + s / kSamples;
        const auto i = static_cast<std::size_t>(sy) * static_cast<std::size_t>(width_) +
                       static_cast<std::size_t>(sx);
        const bool edge =
            (sx + 1 < width_ && std::abs(depth_[i] - depth_[i + 1]) > jump) ||
            (sy + 1 < height_ &&
             std::abs(depth_[i] - depth_[i + static_cast<std::size_t>(width_)]) > jump);
        sum += color_[i] * (edge ? 0.35F : 1.0F);
      }
      sum /= static_cast<float>(kSamples * kSamples);
      for (int c = 0; c < 3; ++c)
        image.rgb[(static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                   static_cast<std::size_t>(x)) *
                      3 +
                  static_cast<std::size_t>(c)] = to_srgb(sum(c));
    }
  return image;
}

}  // namespace s3
