#include "mesh/weld.h"

#include <cstdint>
#include <cstring>

namespace s3 {

namespace {

std::uint64_t mix(std::uint64_t h) {
  h ^= h >> 31;
  h *= 0x9e3779b97f4a7c15u;
  return h ^ (h >> 29);
}

std::uint64_t hash_of(const Vec3& p) {
  std::uint64_t h = 0;
  for (int k = 0; k < 3; ++k) {
    std::uint64_t bits;
    std::memcpy(&bits, &p[k], sizeof bits);
    h = mix(h * 0xbf58476d1ce4e5b9u + bits);
  }
  return h;
}

}  // namespace

Welder::Welder(std::size_t expected_points) {
  std::size_t size = 64;
  while (size < 2 * expected_points) size *= 2;
  slots_.assign(size, -1);
}

std::size_t Welder::slot_of(const Vec3& p) const {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t slot = hash_of(p) & mask;; slot = (slot + 1) & mask) {
    if (slots_[slot] < 0) return slot;
    const double* q = coordinates_.data() + 3 * static_cast<std::size_t>(slots_[slot]);
    if (q[0] == p[0] && q[1] == p[1] && q[2] == p[2]) return slot;
  }
}

void Welder::grow() {
  slots_.assign(2 * slots_.size(), -1);
  for (std::size_t v = 0; 3 * v < coordinates_.size(); ++v)
    slots_[slot_of(Eigen::Map<const Vec3>(coordinates_.data() + 3 * v))] = static_cast<Index>(v);
}

Index Welder::add(const Vec3& point) {
  const Vec3 p = point + Vec3::Zero();  // −0 + 0 = 0
  if (2 * (coordinates_.size() / 3) >= slots_.size()) grow();
  const std::size_t slot = slot_of(p);
  if (slots_[slot] < 0) {
    slots_[slot] = static_cast<Index>(coordinates_.size() / 3);
    coordinates_.insert(coordinates_.end(), p.data(), p.data() + 3);
  }
  return slots_[slot];
}

Points Welder::take() {
  Points points = Eigen::Map<const Points>(coordinates_.data(),
                                           static_cast<Eigen::Index>(coordinates_.size() / 3), 3);
  coordinates_.clear();
  slots_.assign(64, -1);
  return points;
}

}  // namespace s3
