// Three numbers in vector registers. Each operation computes two numbers at once. Choices need no
// branch. Results have the same bits as if computed with single doubles.
//
// Thread safety: values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace sleight::physics {

struct Lanes {
  // Compilers map these types to the processor's registers. On plain x86-64, these hold pairs of
  // doubles.
  using Two = double __attribute__((vector_size(16)));
  using Mask = std::int64_t __attribute__((vector_size(16)));

  Two xy{};
  Two z{};  ///< the second element is unused; 0 where it would be read

  static Lanes all(double x) { return {Two{x, x}, Two{x, x}}; }
  template <class Vector>
  static Lanes of(const Vector& v) {
    Two xy;
    std::memcpy(&xy, v.data(), sizeof xy);
    return {xy, Two{v[2], 0}};
  }
  void set(std::size_t axis, double value) {
    if (axis < 2) {
      xy[axis] = value;
    } else {
      z[0] = value;
    }
  }

  friend Lanes operator+(const Lanes& a, const Lanes& b) { return {a.xy + b.xy, a.z + b.z}; }
  friend Lanes operator-(const Lanes& a, const Lanes& b) { return {a.xy - b.xy, a.z - b.z}; }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return {a.xy * b.xy, a.z * b.z}; }
  friend Lanes operator-(const Lanes& a) { return {-a.xy, -a.z}; }
};

inline double dot(const Lanes& a, const Lanes& b) {
  const Lanes::Two xy = a.xy * b.xy;
  return (xy[0] + xy[1]) + a.z[0] * b.z[0];
}

/// Result of a comparison: for each axis, all bits are set, or none.
struct LaneMask {
  Lanes::Mask xy;
  Lanes::Mask z;
  static LaneMask all(bool set) {
    const std::int64_t bits = -std::int64_t{set};
    return {Lanes::Mask{bits, bits}, Lanes::Mask{bits, bits}};
  }
  friend LaneMask operator&(const LaneMask& a, const LaneMask& b) {
    return {a.xy & b.xy, a.z & b.z};
  }
  friend LaneMask operator|(const LaneMask& a, const LaneMask& b) {
    return {a.xy | b.xy, a.z | b.z};
  }
  bool any() const { return ((xy[0] | xy[1]) | z[0]) != 0; }
};

inline LaneMask operator>(const Lanes& a, const Lanes& b) {
  return {a.xy > b.xy, a.z > b.z};
}
/// Returns `a` where the mask is set, otherwise 0.
inline Lanes where(const LaneMask& mask, const Lanes& a) {
  return {reinterpret_cast<Lanes::Two>(mask.xy & reinterpret_cast<Lanes::Mask>(a.xy)),
          reinterpret_cast<Lanes::Two>(mask.z & reinterpret_cast<Lanes::Mask>(a.z))};
}
inline Lanes choose(const LaneMask& mask, const Lanes& a, const Lanes& b) {
  return {mask.xy ? a.xy : b.xy, mask.z ? a.z : b.z};
}
inline Lanes absolute(const Lanes& a) {
  constexpr Lanes::Mask k_all_but_sign = {INT64_MAX, INT64_MAX};
  return where({k_all_but_sign, k_all_but_sign}, a);
}

}  // namespace sleight::physics
