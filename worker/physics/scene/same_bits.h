// Bitwise equality of numbers: 0 and -0 differ, and a NaN equals itself.
#pragma once

#include <bit>
#include <cstdint>

#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

inline bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
inline bool same(const Vec3& a, const Vec3& b) {
  return same(a.x(), b.x()) && same(a.y(), b.y()) && same(a.z(), b.z());
}
inline bool same(const Quat& a, const Quat& b) {
  return same(a.w(), b.w()) && same(a.x(), b.x()) && same(a.y(), b.y()) && same(a.z(), b.z());
}

}  // namespace sleight::physics
