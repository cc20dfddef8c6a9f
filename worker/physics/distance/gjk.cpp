#include "worker/physics/distance/gjk.h"

#include "worker/physics/distance/separation.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;

// A part of the simplex. Stores the part's closest point, supporting points and weights.
struct Part {
  Vec3 closest = Vec3::Zero();
  double square = 0;  ///< |closest|^2
  std::array<int, 3> index{};
  std::array<double, 3> weight{};
  int count = 0;
};

Part of_point(const Simplex& simplex, int i) {
  const Vec3& p = simplex.points[static_cast<std::size_t>(i)].difference_m;
  return {.closest = p, .square = dot(p, p), .index = {i}, .weight = {1}, .count = 1};
}

Part of_segment(const Simplex& simplex, int i, int j) {
  const Vec3& p = simplex.points[static_cast<std::size_t>(i)].difference_m;
  const Vec3& q = simplex.points[static_cast<std::size_t>(j)].difference_m;
  const Vec3 along = q - p;
  const double length_square = dot(along, along);
  const double from_p = -dot(p, along);
  if (!(from_p > 0)) return of_point(simplex, i);
  if (!(from_p < length_square)) return of_point(simplex, j);
  // If the result is short, (along x p) x along has an accurate direction. The direction of p + t
  // along would be inaccurate.
  Part part;
  part.closest = cross(cross(along, p), along) / length_square;
  part.square = dot(part.closest, part.closest);
  const double t = from_p / length_square;
  part.index = {i, j};
  part.weight = {1 - t, t};
  part.count = 2;
  return part;
}

Part of_triangle(const Simplex& simplex, int i, int j, int k) {
  const Vec3& p = simplex.points[static_cast<std::size_t>(i)].difference_m;
  const Vec3& q = simplex.points[static_cast<std::size_t>(j)].difference_m;
  const Vec3& r = simplex.points[static_cast<std::size_t>(k)].difference_m;
  const Vec3 normal = cross(q - p, r - p);
  const double normal_square = dot(normal, normal);
  // Each value is |normal| times twice the signed area of a triangle: a side and the origin's foot.
  const double at_p = dot(normal, cross(q, r));
  const double at_q = dot(normal, cross(r, p));
  const double at_r = dot(normal, cross(p, q));
  if (at_p >= 0 && at_q >= 0 && at_r >= 0 && normal_square > 0) {
    Part part;
    const double sum = (at_p + at_q) + at_r;
    part.closest = dot(normal, p) / normal_square * normal;
    part.square = dot(part.closest, part.closest);
    part.index = {i, j, k};
    part.weight = {at_p / sum, at_q / sum, at_r / sum};
    part.count = 3;
    if (sum > 0) return part;
  }
  // The foot is outside. The closest point is on a side that separates the foot from the triangle.
  Part best;
  const bool all = !(normal_square > 0);
  const auto offer = [&](const Part& part) {
    if (best.count == 0 || part.square < best.square) best = part;
  };
  if (all || !(at_p >= 0)) offer(of_segment(simplex, j, k));
  if (all || !(at_q >= 0)) offer(of_segment(simplex, k, i));
  if (all || !(at_r >= 0)) offer(of_segment(simplex, i, j));
  if (best.count == 0) {
    offer(of_segment(simplex, j, k));
    offer(of_segment(simplex, k, i));
    offer(of_segment(simplex, i, j));
  }
  return best;
}

// Returns false if the origin is strictly inside the tetrahedron.
bool of_tetrahedron(const Simplex& simplex, Part& best) {
  bool outside = false;
  constexpr std::array<std::array<int, 4>, 4> k_faces{
      {{1, 2, 3, 0}, {2, 3, 0, 1}, {3, 0, 1, 2}, {0, 1, 2, 3}}};
  for (const auto& [i, j, k, opposite] : k_faces) {
    const Vec3& p = simplex.points[static_cast<std::size_t>(i)].difference_m;
    const Vec3& q = simplex.points[static_cast<std::size_t>(j)].difference_m;
    const Vec3& r = simplex.points[static_cast<std::size_t>(k)].difference_m;
    const Vec3& inner = simplex.points[static_cast<std::size_t>(opposite)].difference_m;
    const Vec3 normal = cross(q - p, r - p);
    const double origin_side = -dot(normal, p);
    const double inner_side = dot(normal, inner - p);
    const bool inside = inner_side > 0 ? origin_side > 0 : inner_side < 0 && origin_side < 0;
    if (inside) continue;
    const Part part = of_triangle(simplex, i, j, k);
    if (!outside || part.square < best.square) best = part;
    outside = true;
  }
  return outside;
}

}  // namespace

bool reduce(Simplex& simplex, Vec3& closest) {
  Part part = of_point(simplex, 0);
  if (simplex.count == 2) {
    part = of_segment(simplex, 0, 1);
  } else if (simplex.count == 3) {
    part = of_triangle(simplex, 0, 1, 2);
  } else if (simplex.count == 4 && !of_tetrahedron(simplex, part)) {
    return false;
  }
  const auto points = simplex.points;
  for (int i = 0; i < part.count; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    simplex.points[slot] = points[static_cast<std::size_t>(part.index[slot])];
    simplex.weights[slot] = part.weight[slot];
  }
  simplex.count = part.count;
  closest = part.closest;
  return true;
}

GjkOutcome descend(const PiecePair& pair, bool climb, Simplex& simplex, Vec3& closest) {
  double square = simplex.count > 0 ? dot(closest, closest) : 0;
  for (int iteration = 0; iteration < k_gjk_iterations_max; ++iteration) {
    const Vec3 in_b = pair.in_b(closest);
    SimplexPoint next;
    if (climb) {
      next.a = climbed_vertex(pair.a, closest, simplex.points[0].a);
      next.b = climbed_vertex(pair.b, -in_b, simplex.points[0].b);
    } else {
      next.a = furthest_vertex(pair.a, closest);
      next.b = furthest_vertex(pair.b, -in_b);
    }
    next.difference_m = pair.vertex_of_b(next.b) - pair.vertex_of_a(next.a);
    // Stop if the new pair of vertices is not closer than the simplex's points.
    if (simplex.count > 0) {
      for (int i = 0; i < simplex.count; ++i) {
        const SimplexPoint& known = simplex.points[static_cast<std::size_t>(i)];
        if (known.a == next.a && known.b == next.b) return GjkOutcome::separated;
      }
      const double gain = square - dot(closest, next.difference_m);
      if (gain <= 0 || gain * gain <= pair.rounding_m * pair.rounding_m * square)
        return GjkOutcome::separated;
    }
    const Simplex before = simplex;
    simplex.points[static_cast<std::size_t>(simplex.count++)] = next;
    Vec3 candidate;
    if (!reduce(simplex, candidate)) return GjkOutcome::overlapping;
    const double candidate_square = dot(candidate, candidate);
    if (before.count > 0 && !(candidate_square < square)) {
      simplex = before;
      return GjkOutcome::separated;
    }
    closest = candidate;
    square = candidate_square;
    if (!(square > 0)) return GjkOutcome::overlapping;
  }
  return GjkOutcome::separated;
}

}  // namespace sleight::physics
