// Derives the faces of two triangles at once, one in each half of a vector register.
//
// Idea. Deriving a face takes the same hundred or so operations for every triangle. So deriving two
// faces at once takes hardly longer than deriving one. Each result has the same bits as scalar
// operations.
//
// Thread safety: pure functions.
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <array>
#include <cmath>
#include <cstdint>

#include "worker/physics/shape/triangle_mesh.h"

namespace sleight::physics::face_pair {

// Compilers translate these types to the processor's registers.
using Two = double __attribute__((vector_size(16)));
using Mask = std::int64_t __attribute__((vector_size(16)));

/// One vector for each of the two triangles.
struct Pair {
  Two x, y, z;
  friend Pair operator-(const Pair& a, const Pair& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Pair operator/(const Pair& a, Two b) { return {a.x / b, a.y / b, a.z / b}; }
};

inline Pair pair_of(const Vec3& first, const Vec3& second) {
  return {Two{first.x(), second.x()}, Two{first.y(), second.y()}, Two{first.z(), second.z()}};
}
inline void put(const Pair& pair, Vec3& first, Vec3& second) {
  first = {pair.x[0], pair.y[0], pair.z[0]};
  second = {pair.x[1], pair.y[1], pair.z[1]};
}
inline Two dot(const Pair& a, const Pair& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}
inline Pair cross(const Pair& a, const Pair& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Two greatest(Two a, Two b) {
  return a > b ? a : b;
}
inline Two roots(Two a) {
#ifdef __SSE2__
  return _mm_sqrt_pd(a);
#else
  return Two{std::sqrt(a[0]), std::sqrt(a[1])};
#endif
}

using Corners = std::array<const Vec3*, 3>;

/// Derives both faces. If a triangle is thinner than k_mesh_sliver, its face is invalid, and the
/// result is false. REQUIRES: no coordinate's square or cube overflows.
inline bool derive(const Corners& first_m, const Corners& second_m, MeshFace& first,
                   MeshFace& second) {
  const Pair a = pair_of(*first_m[0], *second_m[0]);
  const Pair b = pair_of(*first_m[1], *second_m[1]);
  const Pair c = pair_of(*first_m[2], *second_m[2]);
  const Pair ab = b - a;
  const Pair bc = c - b;
  const Pair ca = a - c;
  const Pair across = cross(ab, c - a);
  const Two area = roots(dot(across, across));
  const Pair normal = across / area;
  put(normal, first.normal, second.normal);
  const Two offset_m = dot(normal, a);
  first.offset_m = offset_m[0];
  second.offset_m = offset_m[1];
  const auto side = [&](std::size_t k, const Pair& from, const Pair& along) {
    const Pair inwards = cross(normal, along);
    const Pair unit = inwards / roots(dot(inwards, inwards));
    put(unit, first.inward[k], second.inward[k]);
    const Two at_m = dot(unit, from);
    first.inward_offset_m[k] = at_m[0];
    second.inward_offset_m[k] = at_m[1];
  };
  side(0, a, ab);
  side(1, b, bc);
  side(2, c, ca);
  // The root of the greatest square equals the greatest root, bit for bit. `area` is the longest
  // side times the height on that side.
  const Two longest = roots(greatest(greatest(dot(ab, ab), dot(bc, bc)), dot(ca, ca)));
  const Mask sound = (area > k_mesh_sliver * (longest * longest)) & (longest > k_mesh_point_m);
  return (sound[0] & sound[1]) != 0;
}

}  // namespace sleight::physics::face_pair
