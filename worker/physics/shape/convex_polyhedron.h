// Convex polyhedra: vertices, faces, edges, and what distance and mass computations need of them.
//
// Idea. A ConvexPolyhedron is the convex hull of a set of points. It is built once and then read
// many times, so all that can be derived is stored in flat arrays: outward planes, the inward
// normals of a face's sides (to ask whether a point lies above the face), the neighbours of each
// vertex (to climb to the furthest vertex of a direction), and the coordinates once more by axis
// (to scan all vertices at once).
//
// The hull is exact on a grid of 2^-52 of the extent (the longest side of the bounding box): points
// are rounded to it, and the sign of every volume is computed without error in integers. So there
// is no input for which the construction goes astray by rounding. Triangles of that hull are then
// merged into one polygon where their corners lie within k_hull_coplanar of the extent of the
// largest one's plane. The vertices keep the coordinates that were given, bit for bit.
//
// Invariants
//   1. Vertices are in the order of the points given; points inside the hull, inside a face or an
//      edge, or as close to an earlier point as the tolerance, are left out. Every point given lies
//      within 8 tolerances of the polyhedron.
//   2. A face's sides run anticlockwise seen from outside; its normal has length 1 to rounding;
//      dot(normal, v) <= offset_m for all its vertices, with equality for one. Each edge has two
//      different faces, face[0] on the left of vertex[0] -> vertex[1]; V - E + F = 2.
//   3. All arrays are a function of the points alone.
// A ConvexView borrows these arrays, so that a single triangle or a point (small_pieces.h) can be
// handed to the same algorithms. A triangle counts as a polyhedron with two opposite faces.
// Thread safety: values; const access from several threads is safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/math/vector.h"
#include "worker/physics/shape/shape_error.h"

namespace sleight::physics {

using math::Mat3;
using math::Vec3;

/// Vertices, edges, faces and sides are counted with 16 bits: 6 * 1024 sides at most.
inline constexpr std::size_t k_hull_points_max = 1024;
/// Tolerance of the hull, of its extent. Rotating and shifting a shape moves its vertices by some
/// 1e-15; a larger tolerance would flatten faces by more than the distance computation errs.
inline constexpr double k_hull_coplanar = 1e-12;
/// Bodies thinner than this part of their extent are refused as flat: their normals would carry
/// rounding errors of 1e-10, and no scene means them.
inline constexpr double k_hull_flat = 1e-6;

/// One side of a face, from `vertex` to that of the face's next side.
struct Side {
  Vec3 inward = Vec3::Zero();  ///< unit; in the face's plane, at right angles to the side
  double offset_m = 0;         ///< dot(inward, p) - offset_m > 0 for p on the face's side of it
  std::uint16_t vertex = 0;
  std::uint16_t edge = 0;
};

struct Face {
  Vec3 normal = Vec3::Zero();  ///< unit, outward
  double offset_m = 0;         ///< the body lies where dot(normal, p) <= offset_m
  std::uint16_t first_side = 0;
  std::uint16_t side_count = 0;
};

struct Edge {
  std::array<std::uint16_t, 2> vertex{};
  std::array<std::uint16_t, 2> face{};
  std::array<std::uint16_t, 2> side{};  ///< this edge as a side of face[0] and of face[1]
};

class RoundPiece;

/// Borrowed arrays of a convex piece; of a round one none but that piece itself. REQUIRES: the
/// owner stays where it is while the view is used.
struct ConvexView {
  const RoundPiece* round = nullptr;  ///< round_piece.h; null: a polyhedron, a triangle, a point
  const Vec3* vertices_m = nullptr;
  const double* xs_m = nullptr;  ///< x of all vertices, padded with vertex 0 to a multiple of four
  const double* ys_m = nullptr;
  const double* zs_m = nullptr;
  const Face* faces = nullptr;
  const Side* sides = nullptr;
  const Edge* edges = nullptr;
  /// Of vertex v, the entries ring_first[v] to ring_first[v + 1] of the three arrays below.
  const std::uint16_t* ring_first = nullptr;
  const std::uint16_t* ring_vertices = nullptr;  ///< its neighbours, ascending
  const std::uint16_t* ring_edges = nullptr;     ///< the edges to these
  const std::uint16_t* ring_faces = nullptr;     ///< its faces, ascending; as many as edges
  std::uint16_t vertex_count = 0;
  std::uint16_t face_count = 0;
  std::uint16_t edge_count = 0;
  std::uint16_t padded_count = 0;
  double r_outer_m = 0;          ///< distance of the furthest vertex from the frame's origin
  Vec3 centre_m = Vec3::Zero();  ///< mean of the vertices
};

class ConvexPolyhedron {
 public:
  /// The tetrahedron of no size at the origin; exists so that containers can be resized.
  ConvexPolyhedron() = default;

  std::span<const Vec3> vertices_m() const { return vertices_m_; }
  std::span<const Face> faces() const { return faces_; }
  std::span<const Side> sides() const { return sides_; }
  std::span<const Side> sides_of(const Face& face) const {
    return std::span(sides_).subspan(face.first_side, face.side_count);
  }
  std::span<const Edge> edges() const { return edges_; }
  std::span<const std::uint16_t> neighbours_of(std::size_t vertex) const {
    return std::span(ring_vertices_)
        .subspan(ring_first_[vertex], std::size_t{ring_first_[vertex + 1]} - ring_first_[vertex]);
  }
  /// Mean of the vertices, in the body's frame.
  const Vec3& centre_m() const { return centre_m_; }
  /// Every point of the body is this close to the frame's origin.
  double r_outer_m() const { return r_outer_m_; }
  /// The ball of this radius about the origin lies inside; negative if the origin lies outside.
  double r_inner_m() const { return r_inner_m_; }

  /// Valid until this polyhedron is changed, moved or destroyed.
  ConvexView view() const;

 private:
  friend ConvexPolyhedron polyhedron_of_loops(std::span<const Vec3> vertices_m,
                                              std::span<const std::vector<std::uint16_t>> loops);
  struct DirectedEdge;
  /// The face of a loop and its sides: plane from the loop, inward normals from plane and side.
  void add_face(std::span<const std::uint16_t> loop, std::vector<DirectedEdge>& directed);
  /// Edges: each side meets the opposite side of another face.
  void join_sides(std::vector<DirectedEdge>& directed);
  void index_rings();
  /// Bounds, and the coordinates by axis.
  void index_axes();

  std::vector<Vec3> vertices_m_;
  std::vector<double> by_axis_m_;  ///< all x, then all y, then all z, each padded
  std::vector<Face> faces_;
  std::vector<Side> sides_;
  std::vector<Edge> edges_;
  std::vector<std::uint16_t> ring_first_;
  std::vector<std::uint16_t> ring_vertices_;
  std::vector<std::uint16_t> ring_edges_;
  std::vector<std::uint16_t> ring_faces_;
  Vec3 centre_m_ = Vec3::Zero();
  double r_outer_m_ = 0;
  double r_inner_m_ = 0;
};

/// The convex hull of points, in their frame. Time grows with points times faces: 60 points take
/// some 0.1 ms, 500 some 6 ms.
base::Result<ConvexPolyhedron, ShapeError> convex_hull(std::span<const Vec3> points_m);

/// The same polyhedron with each vertex v at product(rotation, v) + shift_m: faces and edges keep
/// their numbers. REQUIRES: rotation is orthonormal to rounding, with determinant 1.
ConvexPolyhedron moved(const ConvexPolyhedron& polyhedron, const Mat3& rotation,
                       const Vec3& shift_m);

/// A polyhedron from its vertices and the anticlockwise vertex loops of its faces. For makers that
/// know the topology; nothing is merged or checked but what must hold for the arrays to make sense.
/// REQUIRES: the loops bound a convex body (for a triangle: two opposite loops).
ConvexPolyhedron polyhedron_of_loops(std::span<const Vec3> vertices_m,
                                     std::span<const std::vector<std::uint16_t>> loops);

}  // namespace sleight::physics
