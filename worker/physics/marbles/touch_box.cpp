#include "worker/physics/marbles/touch_box.h"

#include <cmath>
#include <cstdint>
#include <cstring>

namespace sleight::physics {
namespace {

// Compilers map these types to vector registers. Elements are x, y, z; the fourth is unused.
using Floats = float __attribute__((vector_size(16)));
using Bits = std::int32_t __attribute__((vector_size(16)));
using Two = double __attribute__((vector_size(16)));

constexpr Bits k_axes{-1, -1, -1, 0};
constexpr Bits k_sign{INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};

Floats all(float x) {
  return Floats{x, x, x, x};
}
Bits bits_of(Floats a) {
  return reinterpret_cast<Bits>(a);
}
Floats floats_from(Bits a) {
  return reinterpret_cast<Floats>(a);
}
Floats least(Floats a, Floats b) {
  return a < b ? a : b;
}
Floats greatest(Floats a, Floats b) {
  return a > b ? a : b;
}
Floats absolute(Floats a) {
  return floats_from(bits_of(a) & ~k_sign);
}
Floats roots(Floats a) {
#ifdef __SSE2__
  return _mm_sqrt_ps(a);
#else
  return Floats{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
#endif
}

/// Converts to floats. The padding of touch boxes is much larger than the rounding.
Floats floats_of(Two xy, Two z) {
#ifdef __SSE2__
  return _mm_movelh_ps(_mm_cvtpd_ps(xy), _mm_cvtpd_ps(z));
#else
  return Floats{static_cast<float>(xy[0]), static_cast<float>(xy[1]), static_cast<float>(z[0]), 0};
#endif
}
Two xy_of(const Vec3& v) {
  Two xy;
  std::memcpy(&xy, v.data(), sizeof xy);
  return xy;
}
Two z_of(const Vec3& v) {
  return Two{v.z(), 0};
}
Floats direction_of(const Vec3& v) {
  return floats_of(xy_of(v), z_of(v));
}

float dot(Floats a, Floats b) {
  const Floats each = a * b;
  return (each[0] + each[1]) + each[2];
}

Floats yzx(Floats a) {
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}
Floats zxy(Floats a) {
  return __builtin_shufflevector(a, a, 2, 0, 1, 3);
}

/// For each axis, returns the maximum component of unit vectors that are perpendicular to a given
/// one.
Floats across(Floats parts) {
  return roots(greatest(1 - parts * parts, Floats{}));
}

struct Corners {
  Floats low;
  Floats high;
};

/// Minimum and maximum of each coordinate of some unit vectors: the directions from a feature to
/// the centres in its region.
struct Spread {
  Floats low;
  Floats high;
};

/// For an edge, the unit vectors are perpendicular to the edge. If it has two faces, the vectors
/// are between them.
[[gnu::always_inline]] inline Spread spread_of_edge(const SphereFeature& edge,
                                                    std::span<const RegionSide> sides) {
  const Floats along = direction_of(edge.direction);
  const Floats furthest = across(along);
  const Spread around{.low = -furthest, .high = furthest};
  if (sides.size() != 4) return around;
  // The region ends at rays perpendicular to the sides' normals. Each ray is on the side of the
  // other normal. If the normals are nearly parallel, rounding hides the right side, so the full
  // circle is used.
  const Floats first = direction_of(sides[2].space.normal);
  const Floats second = direction_of(sides[3].space.normal);
  const Floats along_yzx = yzx(along);
  const Floats along_zxy = zxy(along);
  const Floats ray_a = yzx(first) * along_zxy - zxy(first) * along_yzx;
  const Floats ray_b = yzx(second) * along_zxy - zxy(second) * along_yzx;
  const float side_a = dot(ray_a, second);
  const float side_b = dot(ray_b, first);
  constexpr float k_unclear = 1e-4F;
  if (std::fabs(side_a) < k_unclear || std::fabs(side_b) < k_unclear) return around;
  const Floats border_a = floats_from(bits_of(ray_a) ^ (bits_of(all(side_a)) & k_sign));
  const Floats border_b = floats_from(bits_of(ray_b) ^ (bits_of(all(side_b)) & k_sign));
  // For each axis, project the axis onto the plane perpendicular to the edge. If the region
  // contains the projection, the projection's direction is the extreme. Otherwise a border ray is
  // the extreme.
  const Floats nearly = all(1e-5F);
  return {.low = greatest(first, second) > nearly ? least(border_a, border_b) : around.low,
          .high = least(first, second) < -nearly ? greatest(border_a, border_b) : around.high};
}

/// For a vertex, the unit vectors make an obtuse angle with each of its edges.
[[gnu::always_inline]] inline Spread spread_of_vertex(std::span<const RegionSide> sides) {
  // Rounding to float preserves the order, so the maximum can be taken in doubles.
  Two most_xy{}, most_z{}, smallest_xy{}, smallest_z{};
  for (const RegionSide& side : sides) {
    const Two xy = xy_of(side.space.normal);
    const Two z = z_of(side.space.normal);
    most_xy = most_xy > xy ? most_xy : xy;
    most_z = most_z > z ? most_z : z;
    smallest_xy = smallest_xy < xy ? smallest_xy : xy;
    smallest_z = smallest_z < z ? smallest_z : z;
  }
  return {.low = -across(floats_of(most_xy, most_z)),
          .high = across(floats_of(smallest_xy, smallest_z))};
}

[[gnu::always_inline]] inline Spread spread_of(const SphereFeature& feature,
                                               std::span<const RegionSide> sides) {
  if (feature.kind == FeatureKind::edge) return spread_of_edge(feature, sides);
  if (feature.kind == FeatureKind::vertex) return spread_of_vertex(sides);
  const Floats normal = direction_of(feature.direction);
  return {.low = normal, .high = normal};
}

Floats floats_from(const std::array<float, 4>& numbers) {
  Floats four;
  std::memcpy(&four, numbers.data(), sizeof four);
  return four;
}
void put(Floats four, std::array<float, 4>& numbers) {
  std::memcpy(numbers.data(), &four, sizeof four);
}

/// Inline, so that a loop over features loads constants once.
[[gnu::always_inline]] inline Corners corners_of(const SphereFeature& feature,
                                                 std::span<const RegionSide> sides,
                                                 const FeatureExtent& extent, float reach_m) {
  const Spread spread = spread_of(feature, sides);
  const Floats pad = floats_from(extent.pad_m);
  const Floats low = (floats_from(extent.low_m) + least(reach_m * spread.low, Floats{})) - pad;
  const Floats high =
      (floats_from(extent.high_m) + greatest(reach_m * spread.high, Floats{})) + pad;
  return {.low = floats_from(bits_of(low) & k_axes), .high = floats_from(bits_of(high) & k_axes)};
}

void put(const Corners& corners, TouchBox& box) {
  put(corners.low, box.low_m);
  put(corners.high, box.high_m);
}

bool is_in(const Corners& inner, const TouchBox& outer) {
  const Bits beyond =
      (inner.low < floats_from(outer.low_m)) | (inner.high > floats_from(outer.high_m));
#ifdef __SSE2__
  return _mm_movemask_ps(floats_from(beyond)) == 0;
#else
  return (beyond[0] | beyond[1] | beyond[2]) == 0;
#endif
}

}  // namespace

FeatureExtent extent_of(const Box& own, float reach_m) {
  const Floats low{own.low_m[0], own.low_m[1], own.low_m[2], 0};
  const Floats high{own.high_m[0], own.high_m[1], own.high_m[2], 0};
  const Floats pad =
      static_cast<float>(k_touch_box_pad_m) + 0x1p-18F * (absolute(low) + absolute(high) + reach_m);
  FeatureExtent extent;
  put(low, extent.low_m);
  put(high, extent.high_m);
  put(floats_from(bits_of(pad) & k_axes), extent.pad_m);
  return extent;
}

TouchBox touch_box_of(const SphereFeature& feature, std::span<const RegionSide> sides,
                      const FeatureExtent& extent, float reach_m) {
  TouchBox box;
  put(corners_of(feature, sides, extent, reach_m), box);
  return box;
}

void write_touch_boxes(const StaticGeometry& statics, std::span<const FeatureId> features,
                       float reach_m, const TouchBoxes& table, std::vector<FeatureId>& outgrown) {
  for (const FeatureId f : features) {
    const SphereFeature& feature = statics.feature(f);
    if (StaticGeometry::is_absent(feature)) {
      table.boxes[f] = k_unmeetable;
      continue;
    }
    const Corners corners = corners_of(feature, statics.sides(feature), table.extents[f], reach_m);
    put(corners, table.boxes[f]);
    if (!is_in(corners, table.homes[f])) outgrown.push_back(f);
  }
}

}  // namespace sleight::physics
