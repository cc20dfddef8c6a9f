#include "tests/unit/worker/physics/distance/support.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "common/math/elementary.h"
#include "tests/support/property.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using Long3 = std::array<long double, 3>;

Long3 operator-(const Long3& a, const Long3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Long3 operator+(const Long3& a, const Long3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Long3 operator*(long double s, const Long3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
long double dotl(const Long3& a, const Long3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Long3 crossl(const Long3& a, const Long3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
long double norml(const Long3& a) {
  return std::sqrt(dotl(a, a));
}
long double clampl(long double x) {
  return std::clamp(x, 0.0L, 1.0L);
}

std::vector<Long3> world_vertices(const ConvexView& piece, const PlacedPose& pose) {
  std::vector<Long3> result;
  for (std::size_t v = 0; v < piece.vertex_count; ++v) {
    const Vec3& p = piece.vertices_m[v];
    Long3 q{};
    for (int i = 0; i < 3; ++i) {
      q[static_cast<std::size_t>(i)] = static_cast<long double>(pose.position_m[i]) +
                                       static_cast<long double>(pose.rotation(i, 0)) * p.x() +
                                       static_cast<long double>(pose.rotation(i, 1)) * p.y() +
                                       static_cast<long double>(pose.rotation(i, 2)) * p.z();
    }
    result.push_back(q);
  }
  return result;
}

long double point_segment(const Long3& p, const Long3& a, const Long3& b) {
  const Long3 along = b - a;
  return norml(p - (a + clampl(dotl(p - a, along) / dotl(along, along)) * along));
}

// Returns infinity if the foot is outside the triangle, because an edge is closer then.
long double point_triangle(const Long3& p, const Long3& a, const Long3& b, const Long3& c) {
  const Long3 normal = crossl(b - a, c - a);
  const long double inside_ab = dotl(crossl(b - a, p - a), normal);
  const long double inside_bc = dotl(crossl(c - b, p - b), normal);
  const long double inside_ca = dotl(crossl(a - c, p - c), normal);
  if (inside_ab < 0 || inside_bc < 0 || inside_ca < 0) return INFINITY;
  return std::fabs(dotl(normal, p - a)) / norml(normal);
}

long double segment_segment(const Long3& a, const Long3& b, const Long3& c, const Long3& d) {
  long double best = std::min({point_segment(a, c, d), point_segment(b, c, d),
                               point_segment(c, a, b), point_segment(d, a, b)});
  const Long3 u = b - a, v = d - c, n = crossl(u, v);
  const long double nn = dotl(n, n);
  if (nn > 0) {
    const long double s = dotl(crossl(c - a, v), n) / nn;
    const long double t = dotl(crossl(c - a, u), n) / nn;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1)
      best = std::min(best, std::fabs(dotl(n, c - a)) / std::sqrt(nn));
  }
  return best;
}

long double vertices_to_faces(const std::vector<Long3>& vertices, const ConvexView& piece,
                              const std::vector<Long3>& corners) {
  long double best = INFINITY;
  for (std::size_t f = 0; f < piece.face_count; ++f) {
    const Face& face = piece.faces[f];
    const Side* side = piece.sides + face.first_side;
    for (int k = 1; k + 1 < face.side_count; ++k) {
      for (const Long3& p : vertices)
        best = std::min(best, point_triangle(p, corners[side[0].vertex], corners[side[k].vertex],
                                             corners[side[k + 1].vertex]));
    }
  }
  return best;
}

ConvexPolyhedron good(const ShapeResult& result) {
  CHECK(result.ok());
  return result.value();
}

}  // namespace

random::Stream numbers(std::uint64_t test, std::uint64_t index) {
  return random::Stream({.seed = test, .purpose = random::Purpose::prior}, index);
}

double between(random::Stream& stream, double low, double high) {
  return low + (high - low) * stream.uniform();
}

double log_between(random::Stream& stream, double low, double high) {
  return math::exp(between(stream, math::log(low), math::log(high)));
}

Vec3 random_vector(random::Stream& stream) {
  const double x = between(stream, -1, 1);
  const double y = between(stream, -1, 1);
  return {x, y, between(stream, -1, 1)};
}

Vec3 random_unit(random::Stream& stream) {
  for (;;) {
    const Vec3 v = random_vector(stream);
    if (math::norm(v) > 0.1 && math::norm(v) <= 1) return math::normalized(v);
  }
}

Mat3 random_rotation(random::Stream& stream) {
  const Vec3 x = random_unit(stream);
  Vec3 y = math::cross(x, random_unit(stream));
  while (!(math::norm(y) > 0.1))
    y = math::cross(x, random_unit(stream));
  y = math::normalized(y);
  Mat3 m;
  m.col(0) = x;
  m.col(1) = y;
  m.col(2) = math::cross(x, y);
  return m;
}

Mat3 quarter_turns(random::Stream& stream) {
  const auto x = static_cast<int>(stream.bits() % 3);
  const int y = (x + 1 + static_cast<int>(stream.bits() % 2)) % 3;
  Vec3 ex = Vec3::Zero();
  Vec3 ey = Vec3::Zero();
  ex[x] = stream.bits() % 2 == 0 ? 1 : -1;
  ey[y] = stream.bits() % 2 == 0 ? 1 : -1;
  Mat3 m;
  m.col(0) = ex;
  m.col(1) = ey;
  m.col(2) = math::cross(ex, ey);
  return m;
}

std::unique_ptr<Piece> random_piece(random::Stream& stream, double size_m) {
  auto piece = std::make_unique<Piece>();
  const auto choice = stream.bits() % 8;
  const auto from_points = [&](std::vector<Vec3> points) {
    const auto hull = convex_hull(points);
    if (!hull) return false;
    piece->polyhedron = hull.value();
    return true;
  };
  if (choice < 3) {
    piece->kind = "hull";
    for (;;) {
      const auto count = 4 + stream.bits() % 57;
      const Vec3 stretch(1, between(stream, 0.1, 1), between(stream, 0.1, 1));
      std::vector<Vec3> points;
      for (std::uint64_t i = 0; i < count; ++i)
        points.emplace_back(size_m * random_vector(stream).cwiseProduct(stretch));
      if (from_points(points)) break;
    }
  } else if (choice == 3) {
    piece->kind = "icosphere";
    piece->polyhedron = good(icosphere(size_m, static_cast<int>(stream.bits() % 2)));
  } else if (choice == 4) {
    piece->kind = "cube";
    piece->polyhedron = good(cube(size_m));
  } else if (choice == 5) {
    piece->kind = "perturbed cube";
    const double by = log_between(stream, 1e-9, 0.1);
    const ConvexPolyhedron solid = good(cube(size_m));
    std::vector<Vec3> points;
    for (const Vec3& v : solid.vertices_m())
      points.emplace_back(v + by * size_m * random_vector(stream));
    if (!from_points(points)) piece->polyhedron = solid;
  } else if (choice == 6) {
    piece->kind = "prism";
    piece->polyhedron = good(regular_prism(3 + static_cast<int>(stream.bits() % 10), size_m,
                                           size_m * log_between(stream, 0.1, 3)));
  } else {
    piece->kind = "triangle";
    piece->is_triangle = true;
    for (;;) {
      const Vec3 a = size_m * random_vector(stream);
      const Vec3 b = size_m * random_vector(stream);
      const Vec3 c = size_m * random_vector(stream);
      if (math::norm(math::cross(b - a, c - a)) < 0.05 * size_m * size_m) continue;
      piece->triangle = TrianglePiece(a, b, c);
      break;
    }
  }
  return piece;
}

PlacedPose at_gap(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                  const PlacedPose& pose_b, double gap_m) {
  const Closest now = closest_cold(a, pose_a, b, pose_b);
  PlacedPose moved = pose_b;
  moved.position_m -= (now.gap_m - gap_m) * now.normal;
  return moved;
}

Placement random_placement(random::Stream& stream, const ConvexView& a, const ConvexView& b,
                           double size_m) {
  Placement place;
  place.a.position_m = size_m * random_vector(stream);
  const auto style = stream.bits() % 4;
  if (style < 2) {
    place.a.rotation = random_rotation(stream);
    place.b.rotation = random_rotation(stream);
  } else {
    place.b.rotation = quarter_turns(stream);
    if (style == 3) {
      const Vec3 tilt = log_between(stream, 1e-15, 1e-3) * random_unit(stream);
      const Mat3 turn = math::matrix_of(math::quaternion_of_rotation_vector(tilt));
      Mat3 turned;
      for (int j = 0; j < 3; ++j)
        turned.col(j) = math::product(turn, place.b.rotation.col(j));
      place.b.rotation = turned;
    }
  }
  const double reach_m = a.r_outer_m + b.r_outer_m;
  Vec3 offset = between(stream, 1.001, 3) * reach_m * random_unit(stream);
  // Take steps of an eighth of the size along the axes, so that vertices are exactly above edges.
  if (style >= 2 && stream.bits() % 2 == 0) {
    offset = Vec3::Zero();
    const auto axis = static_cast<int>(stream.bits() % 3);
    offset[axis] = 1.5 * reach_m;
    for (const int other : {(axis + 1) % 3, (axis + 2) % 3})
      offset[other] = size_m * 0.125 * (static_cast<double>(stream.bits() % 17) - 8);
  }
  place.b.position_m = place.a.position_m + offset;
  if (stream.bits() % 4 != 0)
    place.b = at_gap(a, place.a, b, place.b, size_m * log_between(stream, 1e-9, 1e-3));
  return place;
}

double coordinates_m(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                     const PlacedPose& pose_b) {
  return a.r_outer_m + b.r_outer_m + math::norm(pose_b.position_m - pose_a.position_m);
}

long double reference_gap(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b) {
  const auto va = world_vertices(a, pose_a);
  const auto vb = world_vertices(b, pose_b);
  long double best = std::min(vertices_to_faces(va, b, vb), vertices_to_faces(vb, a, va));
  for (std::size_t i = 0; i < a.edge_count; ++i) {
    for (std::size_t j = 0; j < b.edge_count; ++j) {
      best = std::min(best, segment_segment(va[a.edges[i].vertex[0]], va[a.edges[i].vertex[1]],
                                            vb[b.edges[j].vertex[0]], vb[b.edges[j].vertex[1]]));
    }
  }
  return best;
}

double outside_m(const ConvexView& piece, const PlacedPose& pose, const Vec3& point_m) {
  const Vec3 p = transposed_product(pose.rotation, point_m - pose.position_m);
  double worst = 0;
  for (std::size_t f = 0; f < piece.face_count; ++f) {
    const Face& face = piece.faces[f];
    worst = std::max(worst, math::dot(face.normal, p) - face.offset_m);
    // The planes of a triangle's two faces don't bound it, so test its sides too.
    if (piece.face_count > 2) continue;
    for (int k = 0; k < face.side_count; ++k) {
      const Side& side = piece.sides[face.first_side + k];
      worst = std::max(worst, side.offset_m - math::dot(side.inward, p));
    }
  }
  if (piece.face_count == 0) worst = math::norm(p - piece.vertices_m[0]);
  return worst;
}

double certificate_defect(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                          const PlacedPose& pose_b, const Closest& result) {
  const Vec3 apart = result.point_b_m - result.point_a_m;
  return std::max({outside_m(a, pose_a, result.point_a_m), outside_m(b, pose_b, result.point_b_m),
                   math::norm(apart - result.gap_m * result.normal),
                   std::fabs(math::norm(result.normal) - 1) * a.r_outer_m,
                   result.gap_m - separation_along(result.normal, a, pose_a, b, pose_b)});
}

std::uint64_t soaked(std::uint64_t count) {
  return property::long_run() ? 10 * count : count;
}

}  // namespace sleight::physics
