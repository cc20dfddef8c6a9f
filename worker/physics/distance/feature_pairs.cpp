#include "worker/physics/distance/feature_pairs.h"

#include <cmath>

#include "worker/physics/distance/separation.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;
using math::product;

// Error of a direction that is computed from unit vectors and matrices: about ten roundings.
constexpr double k_angle_rounding = 0x1p-49;
// If the sine of two edges' angle is below this, the edges count as parallel, because the normal of
// both would be noise.
constexpr double k_parallel_sine = 1e-13;
// Margins of only_one(), which affect only speed.
constexpr double k_sure_gap_roundings = 0x1p20;  // minimum gap, in roundings
constexpr double k_sure_sine = 0x1p-7;           // minimum sine of two edges
constexpr double k_sure_inside_gaps = 0x1p-4;    // how far points must be inside features, in gaps
// Minimum angle by which a feature's neighbours fall away, as a multiple of rounding / gap.
constexpr double k_sure_turns = 0x1p8;

double sum_of_sizes(const Vec3& v) {
  return std::fabs(v.x()) + std::fabs(v.y()) + std::fabs(v.z());
}

// Returns whether a point is above a face, between the planes through its sides.
bool above_face(const ConvexView& piece, const Face& face, const Vec3& p, double slack_m) {
  const Side* side = piece.sides + face.first_side;
  for (const Side* end = side + face.side_count; side != end; ++side) {
    if (dot(side->inward, p) - side->offset_m < -slack_m) return false;
  }
  return true;
}

// Returns whether no neighbour of a vertex is further along a direction than the vertex. The
// direction is in the piece's frame, and its error is at most `angle_error_rad`.
bool is_furthest(const ConvexView& piece, std::size_t vertex, const Vec3& direction, double slack_m,
                 double angle_error_rad) {
  const Vec3& v = piece.vertices_m[vertex];
  for (std::size_t i = piece.ring_first[vertex]; i < piece.ring_first[vertex + 1]; ++i) {
    const Vec3 step = piece.vertices_m[piece.ring_vertices[i]] - v;
    if (dot(direction, step) > slack_m + angle_error_rad * sum_of_sizes(step)) return false;
  }
  return true;
}

// Returns whether both faces of an edge fall away from the edge along `direction`. The direction is
// perpendicular to the edge.
bool is_furthest(const ConvexView& piece, const Edge& edge, const Vec3& direction,
                 double angle_error_rad) {
  return dot(direction, piece.sides[edge.side[0]].inward) <= angle_error_rad &&
         dot(direction, piece.sides[edge.side[1]].inward) <= angle_error_rad;
}

// Returns whether a point of an edge is at least `margin_m` from both ends.
bool is_inside(const Vec3& from_start, const Vec3& along, double margin_m) {
  const double square = dot(along, along);
  const double part = dot(from_start, along);
  const double margin = margin_m * std::sqrt(square);
  return part >= margin && square - part >= margin;
}

// Returns the error of a direction that is computed from two points at this distance.
double angle_error(const PiecePair& pair, double length_m) {
  return k_angle_rounding + pair.rounding_m / length_m;
}

bool vertex_vertex(const PiecePair& pair, LocalClosest& out) {
  out.point_a_m = pair.vertex_of_a(out.a.index);
  out.point_b_m = pair.vertex_of_b(out.b.index);
  const Vec3 apart = out.point_b_m - out.point_a_m;
  out.gap_m = norm(apart);
  if (!(out.gap_m > 0)) return false;
  out.normal = apart / out.gap_m;
  out.normal_error_rad = angle_error(pair, out.gap_m);
  return true;
}

// Finds the foot of p on the line from `start` along `along`, and the vector from the foot to p.
// Returns false if the foot isn't on the edge.
bool foot_on_edge(const Vec3& p, const Vec3& start, const Vec3& along, Vec3& foot, Vec3& rise) {
  const Vec3 from_start = p - start;
  const double s = dot(from_start, along) / dot(along, along);
  if (!(s >= 0 && s <= 1)) return false;
  foot = start + s * along;
  rise = p - foot;
  return true;
}

bool edge_vertex(const PiecePair& pair, LocalClosest& out) {
  const Edge& edge = pair.a.edges[out.a.index];
  const Vec3 start = pair.vertex_of_a(edge.vertex[0]);
  out.point_b_m = pair.vertex_of_b(out.b.index);
  Vec3 rise;
  if (!foot_on_edge(out.point_b_m, start, pair.vertex_of_a(edge.vertex[1]) - start, out.point_a_m,
                    rise))
    return false;
  out.gap_m = norm(rise);
  if (!(out.gap_m > 0)) return false;
  out.normal = rise / out.gap_m;
  out.normal_error_rad = angle_error(pair, out.gap_m);
  return true;
}

bool vertex_edge(const PiecePair& pair, LocalClosest& out) {
  const Edge& edge = pair.b.edges[out.b.index];
  const Vec3 start = pair.vertex_of_b(edge.vertex[0]);
  const Vec3 along = product(pair.b_in_a.rotation,
                             pair.b.vertices_m[edge.vertex[1]] - pair.b.vertices_m[edge.vertex[0]]);
  out.point_a_m = pair.vertex_of_a(out.a.index);
  Vec3 rise;
  if (!foot_on_edge(out.point_a_m, start, along, out.point_b_m, rise)) return false;
  out.gap_m = norm(rise);
  if (!(out.gap_m > 0)) return false;
  out.normal = -rise / out.gap_m;
  out.normal_error_rad = angle_error(pair, out.gap_m);
  return true;
}

bool face_vertex(const PiecePair& pair, LocalClosest& out) {
  const Face& face = pair.a.faces[out.a.index];
  out.point_b_m = pair.vertex_of_b(out.b.index);
  out.gap_m = dot(face.normal, out.point_b_m) - face.offset_m;
  if (!(out.gap_m > 0) || !above_face(pair.a, face, out.point_b_m, pair.rounding_m)) return false;
  out.normal = face.normal;
  out.normal_error_rad = k_angle_rounding;
  out.point_a_m = out.point_b_m - out.gap_m * face.normal;
  return true;
}

bool vertex_face(const PiecePair& pair, LocalClosest& out) {
  const Face& face = pair.b.faces[out.b.index];
  out.point_a_m = pair.vertex_of_a(out.a.index);
  const Vec3 seen_from_b =
      transposed_product(pair.b_in_a.rotation, out.point_a_m - pair.b_in_a.position_m);
  out.gap_m = dot(face.normal, seen_from_b) - face.offset_m;
  if (!(out.gap_m > 0) || !above_face(pair.b, face, seen_from_b, pair.rounding_m)) return false;
  out.normal = -product(pair.b_in_a.rotation, face.normal);
  out.normal_error_rad = k_angle_rounding;
  out.point_b_m = out.point_a_m + out.gap_m * out.normal;
  return true;
}

bool edge_edge(const PiecePair& pair, LocalClosest& out) {
  const Edge& edge_a = pair.a.edges[out.a.index];
  const Edge& edge_b = pair.b.edges[out.b.index];
  const Vec3 start_a = pair.vertex_of_a(edge_a.vertex[0]);
  const Vec3 along_a = pair.vertex_of_a(edge_a.vertex[1]) - start_a;
  const Vec3 start_b = pair.vertex_of_b(edge_b.vertex[0]);
  const Vec3 along_b = product(pair.b_in_a.rotation, pair.b.vertices_m[edge_b.vertex[1]] -
                                                         pair.b.vertices_m[edge_b.vertex[0]]);
  const Vec3 normal = cross(along_a, along_b);
  const double normal_square = dot(normal, normal);
  const double square_a = dot(along_a, along_a);
  const double square_b = dot(along_b, along_b);
  if (!(normal_square > k_parallel_sine * k_parallel_sine * (square_a * square_b))) return false;
  // Compute the point of A's line nearest to B's line (Lumelsky, "On fast computation of distance
  // between line segments", 1985). This form uses the product of the directions, so the error grows
  // with 1/sine, not with 1/sine^2. B's point is the foot of A's point. So even if A's point is
  // inaccurate, the difference has no component along the edges.
  const Vec3 apart = start_b - start_a;
  const double s = dot(cross(apart, along_b), normal) / normal_square;
  if (!(s >= 0 && s <= 1)) return false;
  out.point_a_m = start_a + s * along_a;
  const double t = dot(out.point_a_m - start_b, along_b) / square_b;
  if (!(t >= 0 && t <= 1)) return false;
  out.point_b_m = start_b + t * along_b;
  const Vec3 rise = out.point_b_m - out.point_a_m;
  const double length_m = norm(rise);
  // If the normal is computed from the edges, its error is 2^-52/sine. If it is computed from the
  // difference, its error is rounding_m/length.
  const double normal_length = std::sqrt(normal_square);
  const double sine = normal_length / std::sqrt(square_a * square_b);
  if (length_m * 0x1p-50 > pair.rounding_m * sine) {
    out.normal = rise / length_m;
    out.gap_m = length_m;
    out.normal_error_rad = angle_error(pair, length_m);
  } else {
    out.normal = normal / (dot(normal, rise) < 0 ? -normal_length : normal_length);
    out.gap_m = dot(out.normal, rise);
    out.normal_error_rad = k_angle_rounding / sine;
  }
  return out.gap_m > 0;
}

}  // namespace

PiecePair::PiecePair(const ConvexView& piece_a, const PlacedPose& pose_a, const ConvexView& piece_b,
                     const PlacedPose& pose_b)
    : a(piece_a), b(piece_b), b_in_a(relative_pose(pose_a, pose_b)) {
  rounding_m = 0x1p-50 * (a.r_outer_m + b.r_outer_m + sum_of_sizes(b_in_a.position_m));
}

bool closest_of_features(const PiecePair& pair, Feature a, Feature b, LocalClosest& out) {
  out.a = a;
  out.b = b;
  using enum FeatureKind;
  if (a.kind == vertex) {
    if (b.kind == vertex) return vertex_vertex(pair, out);
    return b.kind == edge ? vertex_edge(pair, out) : vertex_face(pair, out);
  }
  if (a.kind == edge) {
    if (b.kind == vertex) return edge_vertex(pair, out);
    return b.kind == edge && edge_edge(pair, out);
  }
  return b.kind == vertex && face_vertex(pair, out);
}

bool certified(const PiecePair& pair, const LocalClosest& result) {
  using enum FeatureKind;
  // A normal between points is as uncertain as the points. The gap stays accurate, because its
  // error is proportional to the square of the normal's error.
  const double error_rad = result.normal_error_rad;
  const double slack_m = pair.rounding_m;
  if (result.a.kind == vertex &&
      !is_furthest(pair.a, result.a.index, result.normal, slack_m, error_rad))
    return false;
  if (result.a.kind == edge &&
      !is_furthest(pair.a, pair.a.edges[result.a.index], result.normal, error_rad))
    return false;
  if (result.b.kind == face) return true;
  const Vec3 back = -pair.in_b(result.normal);
  if (result.b.kind == vertex) return is_furthest(pair.b, result.b.index, back, slack_m, error_rad);
  return is_furthest(pair.b, pair.b.edges[result.b.index], back, error_rad);
}

bool only_one(const PiecePair& pair, const LocalClosest& result) {
  using enum FeatureKind;
  if (!(result.gap_m >= k_sure_gap_roundings * pair.rounding_m)) return false;
  const double inside_m = k_sure_inside_gaps * result.gap_m;
  const double falling = k_sure_turns * pair.rounding_m / result.gap_m;
  if (result.a.kind == edge && result.b.kind == edge) {
    const Edge& edge_a = pair.a.edges[result.a.index];
    const Edge& edge_b = pair.b.edges[result.b.index];
    const Vec3 start_a = pair.vertex_of_a(edge_a.vertex[0]);
    const Vec3 start_b = pair.vertex_of_b(edge_b.vertex[0]);
    const Vec3 along_a = pair.vertex_of_a(edge_a.vertex[1]) - start_a;
    const Vec3 along_b = pair.vertex_of_b(edge_b.vertex[1]) - start_b;
    const Vec3 across = cross(along_a, along_b);
    const Vec3 back = -pair.in_b(result.normal);
    return dot(across, across) >=
               k_sure_sine * k_sure_sine * (dot(along_a, along_a) * dot(along_b, along_b)) &&
           is_furthest(pair.a, edge_a, result.normal, -falling / k_sure_sine) &&
           is_furthest(pair.b, edge_b, back, -falling / k_sure_sine) &&
           is_inside(result.point_a_m - start_a, along_a, inside_m) &&
           is_inside(result.point_b_m - start_b, along_b, inside_m);
  }
  if (result.a.kind == face && result.b.kind == vertex) {
    return above_face(pair.a, pair.a.faces[result.a.index], result.point_b_m, -inside_m) &&
           is_furthest(pair.b, result.b.index, -pair.in_b(result.normal), 0, -falling);
  }
  if (result.a.kind == vertex && result.b.kind == face) {
    const Vec3 seen_from_b =
        transposed_product(pair.b_in_a.rotation, result.point_a_m - pair.b_in_a.position_m);
    return above_face(pair.b, pair.b.faces[result.b.index], seen_from_b, -inside_m) &&
           is_furthest(pair.a, result.a.index, result.normal, 0, -falling);
  }
  return false;
}

bool closest_of_parallel_features(const PiecePair& pair, Feature a, Feature b,
                                  const Vec3& point_a_m, const Vec3& point_b_m, LocalClosest& out) {
  out.a = a;
  out.b = b;
  if (a.kind == FeatureKind::face) {
    const Face& face = pair.a.faces[a.index];
    out.normal = face.normal;
    const Vec3 lowest = pair.vertex_of_b(furthest_vertex(pair.b, -pair.in_b(face.normal)));
    out.gap_m = dot(face.normal, lowest) - face.offset_m;
    const double above_m = dot(face.normal, point_b_m) - face.offset_m;
    out.point_a_m = point_b_m - out.gap_m * face.normal;
    out.point_b_m = point_b_m;
    return out.gap_m > 0 && std::fabs(above_m - out.gap_m) <= 2 * pair.rounding_m &&
           above_face(pair.a, face, point_b_m, pair.rounding_m);
  }
  if (b.kind != FeatureKind::face) return false;
  const Face& face = pair.b.faces[b.index];
  out.normal = -product(pair.b_in_a.rotation, face.normal);
  const auto seen_from_b = [&](const Vec3& p) {
    return transposed_product(pair.b_in_a.rotation, p - pair.b_in_a.position_m);
  };
  const Vec3 nearest = seen_from_b(pair.vertex_of_a(furthest_vertex(pair.a, out.normal)));
  out.gap_m = dot(face.normal, nearest) - face.offset_m;
  const Vec3 point = seen_from_b(point_a_m);
  const double above_m = dot(face.normal, point) - face.offset_m;
  out.point_a_m = point_a_m;
  out.point_b_m = point_a_m + out.gap_m * out.normal;
  return out.gap_m > 0 && std::fabs(above_m - out.gap_m) <= 2 * pair.rounding_m &&
         above_face(pair.b, face, point, pair.rounding_m);
}

}  // namespace sleight::physics
