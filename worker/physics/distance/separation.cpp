#include "worker/physics/distance/separation.h"

#include <cmath>
#include <cstring>

namespace sleight::physics {
namespace {

// With vectors of two numbers, as in SSE2, comparisons are cheaper than loads. On other processors
// the compiler emits plain code with the same results.
using Pair = double __attribute__((vector_size(16)));
using Lanes = long long __attribute__((vector_size(16)));

Pair load(const double* from) {
  Pair result;
  std::memcpy(&result, from, sizeof(result));
  return result;
}

}  // namespace

std::uint16_t furthest_vertex(const ConvexView& piece, const Vec3& direction) {
  const Pair dx = {direction.x(), direction.x()};
  const Pair dy = {direction.y(), direction.y()};
  const Pair dz = {direction.z(), direction.z()};
  // Compute four maxima side by side, so that comparisons do not wait for each other.
  Pair best0 = dx * load(piece.xs_m) + dy * load(piece.ys_m) + dz * load(piece.zs_m);
  Pair best1 = dx * load(piece.xs_m + 2) + dy * load(piece.ys_m + 2) + dz * load(piece.zs_m + 2);
  Lanes index0 = {0, 1};
  Lanes index1 = {2, 3};
  Lanes here0 = index0;
  Lanes here1 = index1;
  const Lanes step = {4, 4};
  for (std::size_t i = 4; i < piece.padded_count; i += 4) {
    here0 += step;
    here1 += step;
    const Pair reach0 =
        dx * load(piece.xs_m + i) + dy * load(piece.ys_m + i) + dz * load(piece.zs_m + i);
    const Pair reach1 = dx * load(piece.xs_m + i + 2) + dy * load(piece.ys_m + i + 2) +
                        dz * load(piece.zs_m + i + 2);
    const Lanes more0 = reach0 > best0;
    const Lanes more1 = reach1 > best1;
    best0 = more0 ? reach0 : best0;
    best1 = more1 ? reach1 : best1;
    index0 = more0 ? here0 : index0;
    index1 = more1 ? here1 : index1;
  }
  // If maxima are equal, the lowest index wins. The padding repeats vertex 0, so it never wins.
  double best = best0[0];
  long long index = index0[0];
  const auto offer = [&](double reach, long long at) {
    if (reach > best || (reach == best && at < index)) {
      best = reach;
      index = at;
    }
  };
  offer(best0[1], index0[1]);
  offer(best1[0], index1[0]);
  offer(best1[1], index1[1]);
  return static_cast<std::uint16_t>(index);
}

std::uint16_t climbed_vertex(const ConvexView& piece, const Vec3& direction, std::uint16_t start) {
  // The dot product is written out, because this is the inner loop of every warm descent.
  const double x = direction.x();
  const double y = direction.y();
  const double z = direction.z();
  const auto reach_of = [&](std::size_t vertex) {
    const double* v = piece.vertices_m[vertex].data();
    return (x * v[0] + y * v[1]) + z * v[2];
  };
  std::uint16_t at = start;
  double reach = reach_of(at);
  for (;;) {
    std::uint16_t next = at;
    const std::uint16_t* neighbour = piece.ring_vertices + piece.ring_first[at];
    const std::uint16_t* end = piece.ring_vertices + piece.ring_first[at + std::size_t{1}];
    for (; neighbour != end; ++neighbour) {
      const double candidate = reach_of(*neighbour);
      if (candidate > reach) {
        reach = candidate;
        next = *neighbour;
      }
    }
    if (next == at) return at;
    at = next;
  }
}

double separation_along(const Vec3& axis, const ConvexView& a, const PlacedPose& pose_a,
                        const ConvexView& b, const PlacedPose& pose_b) {
  const Vec3 axis_in_a = transposed_product(pose_a.rotation, axis);
  const Vec3 axis_in_b = transposed_product(pose_b.rotation, axis);
  const Vec3& top = a.vertices_m[furthest_vertex(a, axis_in_a)];
  const Vec3& bottom = b.vertices_m[furthest_vertex(b, -axis_in_b)];
  // Subtract the positions first: far from the world's origin, they nearly cancel.
  return (math::dot(axis, pose_b.position_m - pose_a.position_m) + math::dot(axis_in_b, bottom)) -
         math::dot(axis_in_a, top);
}

double separation_error_m(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b) {
  const Vec3 apart = pose_b.position_m - pose_a.position_m;
  return 0x1p-49 * (a.r_outer_m + b.r_outer_m + std::fabs(apart.x()) + std::fabs(apart.y()) +
                    std::fabs(apart.z()));
}

}  // namespace sleight::physics
