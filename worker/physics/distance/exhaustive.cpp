#include "worker/physics/distance/exhaustive.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>

#include "worker/physics/distance/separation.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;
using math::product;

using VertexSet = std::bitset<k_hull_points_max>;

// Finds the vertex furthest along a unit direction of the piece's frame. Returns all vertices that
// reach within `depth_m` of it.
VertexSet outermost(const ConvexView& piece, const Vec3& direction, double depth_m) {
  const double reach = dot(direction, piece.vertices_m[furthest_vertex(piece, direction)]);
  VertexSet set;
  for (std::size_t v = 0; v < piece.vertex_count; ++v)
    set[v] = dot(direction, piece.vertices_m[v]) >= reach - depth_m;
  return set;
}

bool touches(const Edge& edge, const VertexSet& set) {
  return set[edge.vertex[0]] || set[edge.vertex[1]];
}

bool touches(const ConvexView& piece, const Face& face, const VertexSet& set) {
  const Side* side = piece.sides + face.first_side;
  return std::any_of(side, side + face.side_count, [&](const Side& s) { return set[s.vertex]; });
}

// The unit axis is in A's frame.
double separation(const PiecePair& pair, const Vec3& axis) {
  const Vec3 top = pair.vertex_of_a(furthest_vertex(pair.a, axis));
  const Vec3 bottom = pair.vertex_of_b(furthest_vertex(pair.b, -pair.in_b(axis)));
  return dot(axis, bottom - top);
}

template <class Visit>
void each_pair(const PiecePair& pair, const VertexSet& near_a, const VertexSet& near_b,
               const Visit& visit) {
  using enum FeatureKind;
  const auto feature = [](FeatureKind kind, std::size_t index) {
    return Feature{kind, static_cast<std::uint16_t>(index)};
  };
  for (std::size_t f = 0; f < pair.a.face_count; ++f) {
    if (!touches(pair.a, pair.a.faces[f], near_a)) continue;
    for (std::size_t v = 0; v < pair.b.vertex_count; ++v)
      if (near_b[v]) visit(feature(face, f), feature(vertex, v));
  }
  for (std::size_t f = 0; f < pair.b.face_count; ++f) {
    if (!touches(pair.b, pair.b.faces[f], near_b)) continue;
    for (std::size_t v = 0; v < pair.a.vertex_count; ++v)
      if (near_a[v]) visit(feature(vertex, v), feature(face, f));
  }
  for (std::size_t i = 0; i < pair.a.edge_count; ++i) {
    if (!touches(pair.a.edges[i], near_a)) continue;
    for (std::size_t j = 0; j < pair.b.edge_count; ++j)
      if (touches(pair.b.edges[j], near_b)) visit(feature(edge, i), feature(edge, j));
    for (std::size_t v = 0; v < pair.b.vertex_count; ++v)
      if (near_b[v]) visit(feature(edge, i), feature(vertex, v));
  }
  for (std::size_t v = 0; v < pair.a.vertex_count; ++v) {
    if (!near_a[v]) continue;
    for (std::size_t j = 0; j < pair.b.edge_count; ++j)
      if (touches(pair.b.edges[j], near_b)) visit(feature(vertex, v), feature(edge, j));
    for (std::size_t w = 0; w < pair.b.vertex_count; ++w)
      if (near_b[w]) visit(feature(vertex, v), feature(vertex, w));
  }
}

// A piece's best face: the face with the greatest gap to the other piece.
struct FaceSeparation {
  double gap_m = -std::numeric_limits<double>::infinity();
  std::uint16_t face = 0;
  std::uint16_t vertex = 0;  ///< of the other piece
};

FaceSeparation best_face(const ConvexView& piece, const ConvexView& other,
                         const PlacedPose& other_in_piece) {
  FaceSeparation best;
  for (std::uint16_t f = 0; f < piece.face_count; ++f) {
    const Face& face = piece.faces[f];
    const Vec3 down = -transposed_product(other_in_piece.rotation, face.normal);
    const std::uint16_t v = furthest_vertex(other, down);
    const double gap_m =
        dot(face.normal, to_world(other_in_piece, other.vertices_m[v])) - face.offset_m;
    if (gap_m > best.gap_m) best = {.gap_m = gap_m, .face = f, .vertex = v};
  }
  return best;
}

struct EdgeSeparation {
  double gap_m = -std::numeric_limits<double>::infinity();
  std::uint16_t a = 0;
  std::uint16_t b = 0;
  Vec3 normal = Vec3::Zero();  ///< in B's frame
};

// Finds the products of edges that are normals of the bodies' difference. Both bodies fall away
// from such edges, so the arcs of the two edges' normals cross on the unit sphere. In B's frame, s
// (ea x eb) must point out of A's two sides and into B's two sides, where s is 1 or -1.
EdgeSeparation best_edges(const PiecePair& pair) {
  constexpr double k_sine_min = 1e-9;  // if nearly parallel, the faces' normals are as good
  EdgeSeparation best;
  for (std::uint16_t i = 0; i < pair.a.edge_count; ++i) {
    const Edge& edge_a = pair.a.edges[i];
    const Vec3& start_of_a = pair.a.vertices_m[edge_a.vertex[0]];
    const Vec3 along_a = pair.in_b(pair.a.vertices_m[edge_a.vertex[1]] - start_of_a);
    const Vec3 start_a = pair.in_b(start_of_a - pair.b_in_a.position_m);
    // dot(ea x eb, t) = dot(t x ea, eb).
    const Vec3 left_a = cross(pair.in_b(pair.a.sides[edge_a.side[0]].inward), along_a);
    const Vec3 right_a = cross(pair.in_b(pair.a.sides[edge_a.side[1]].inward), along_a);
    const double square_a = dot(along_a, along_a);
    for (std::uint16_t j = 0; j < pair.b.edge_count; ++j) {
      const Edge& edge_b = pair.b.edges[j];
      const Vec3& start_b = pair.b.vertices_m[edge_b.vertex[0]];
      const Vec3 along_b = pair.b.vertices_m[edge_b.vertex[1]] - start_b;
      const double left = dot(left_a, along_b);
      const double right = dot(right_a, along_b);
      double sign = 0;
      if (left <= 0 && right <= 0) sign = 1;
      if (left >= 0 && right >= 0) sign = -1;
      if (sign == 0) continue;
      const Vec3 normal = sign * cross(along_a, along_b);
      if (dot(normal, pair.b.sides[edge_b.side[0]].inward) < 0 ||
          dot(normal, pair.b.sides[edge_b.side[1]].inward) < 0)
        continue;
      const double normal_square = dot(normal, normal);
      if (!(normal_square > k_sine_min * k_sine_min * (square_a * dot(along_b, along_b)))) continue;
      const double length = std::sqrt(normal_square);
      const double gap_m = dot(normal, start_b - start_a) / length;
      if (gap_m > best.gap_m)
        best = {.gap_m = gap_m, .a = i, .b = j, .normal = Vec3(normal / length)};
    }
  }
  return best;
}

double clamped(double x) {
  return x < 0 ? 0 : (x > 1 ? 1 : x);
}

void fill_edges(const PiecePair& pair, const EdgeSeparation& best, LocalClosest& result) {
  const Edge& edge_a = pair.a.edges[best.a];
  const Edge& edge_b = pair.b.edges[best.b];
  const Vec3 start_a = pair.vertex_of_a(edge_a.vertex[0]);
  const Vec3 along_a = pair.vertex_of_a(edge_a.vertex[1]) - start_a;
  const Vec3 start_b = pair.vertex_of_b(edge_b.vertex[0]);
  const Vec3 along_b = pair.vertex_of_b(edge_b.vertex[1]) - start_b;
  result.a = {FeatureKind::edge, best.a};
  result.b = {FeatureKind::edge, best.b};
  result.normal = product(pair.b_in_a.rotation, best.normal);
  const Vec3 across = cross(along_a, along_b);
  const double s = dot(cross(start_b - start_a, along_b), across) / dot(across, across);
  result.point_a_m = start_a + clamped(s) * along_a;
  result.point_b_m = result.point_a_m + result.gap_m * result.normal;
}

}  // namespace

LocalClosest closest_of_all(const PiecePair& pair, const Vec3& axis, double low_m, double high_m) {
  const double depth_m = std::max(high_m - low_m, 0.0) + 8 * pair.rounding_m;
  const VertexSet near_a = outermost(pair.a, axis, depth_m);
  const VertexSet near_b = outermost(pair.b, -pair.in_b(axis), depth_m);
  double least_m = std::numeric_limits<double>::infinity();
  LocalClosest candidate;
  each_pair(pair, near_a, near_b, [&](Feature a, Feature b) {
    if (closest_of_features(pair, a, b, candidate)) least_m = std::min(least_m, candidate.gap_m);
  });
  // If gaps are equal, prefer the pair with the greatest separation along its normal. If two points
  // nearly touch, the normal between them is noise. The normal of a slightly further face is not.
  LocalClosest best;
  double best_separation_m = -std::numeric_limits<double>::infinity();
  each_pair(pair, near_a, near_b, [&](Feature a, Feature b) {
    if (!closest_of_features(pair, a, b, candidate)) return;
    if (candidate.gap_m > least_m + pair.rounding_m) return;
    const double along_m = separation(pair, candidate.normal);
    if (along_m <= best_separation_m) return;
    best_separation_m = along_m;
    best = candidate;
  });
  return best;
}

LocalClosest least_overlap(const PiecePair& pair) {
  const FaceSeparation face_a = best_face(pair.a, pair.b, pair.b_in_a);
  const FaceSeparation face_b = best_face(pair.b, pair.a, inverse(pair.b_in_a));
  const EdgeSeparation edges = best_edges(pair);
  LocalClosest result;
  result.normal = Vec3(1, 0, 0);
  // If gaps are equal up to rounding, prefer a face to edges, because a face's normal is more
  // accurate. Also prefer A's face to B's face.
  if (face_a.gap_m + pair.rounding_m >= std::max(face_b.gap_m, edges.gap_m) &&
      pair.a.face_count > 0) {
    result.gap_m = face_a.gap_m;
    result.a = {FeatureKind::face, face_a.face};
    result.b = {FeatureKind::vertex, face_a.vertex};
    result.normal = pair.a.faces[face_a.face].normal;
    result.point_b_m = pair.vertex_of_b(face_a.vertex);
    result.point_a_m = result.point_b_m - result.gap_m * result.normal;
  } else if (face_b.gap_m + pair.rounding_m >= edges.gap_m && pair.b.face_count > 0) {
    result.gap_m = face_b.gap_m;
    result.a = {FeatureKind::vertex, face_b.vertex};
    result.b = {FeatureKind::face, face_b.face};
    result.normal = -product(pair.b_in_a.rotation, pair.b.faces[face_b.face].normal);
    result.point_a_m = pair.vertex_of_a(face_b.vertex);
    result.point_b_m = result.point_a_m + result.gap_m * result.normal;
  } else if (std::isfinite(edges.gap_m)) {
    result.gap_m = edges.gap_m;
    fill_edges(pair, edges, result);
  } else {
    // Two coinciding points: any direction works.
    result.point_a_m = pair.vertex_of_a(0);
    result.point_b_m = result.point_a_m;
  }
  return result;
}

}  // namespace sleight::physics
