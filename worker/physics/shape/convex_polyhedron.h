// Convex polyhedra: vertices, faces and edges, and derived data for computing distances and masses.
//
// Idea. A ConvexPolyhedron is the convex hull of a set of points. A polyhedron is built once and
// read many times, so all derived data are stored in flat arrays. Outward planes and the sides'
// inward normals show whether a point is above a face. To find the furthest vertex in a direction,
// algorithms climb from vertex to neighbour, or scan all coordinates. For scans, coordinates are
// stored by axis.
//
// The extent is the longest side of the bounding box. Points are rounded to a grid with a spacing
// of 2^-52 of the extent. The hull of the rounded points is exact: the sign of every volume is
// computed in integers. Then triangles merge into one polygon if their corners are within
// k_hull_coplanar times the extent of the largest triangle's plane. The vertices keep the given
// coordinates, bit for bit.
//
// Invariants
//   1. Vertices are in the order of the given points. A point isn't a vertex if it is inside the
//      hull, a face or an edge, or within the tolerance of an earlier point. All given points are
//      within 8 tolerances of the polyhedron.
//   2. A face's sides run anticlockwise seen from outside. A face's normal has length 1 up to
//      rounding. dot(normal, v) <= offset_m for all its vertices v, and is equal for one. Each edge
//      has two different faces. Seen along vertex[0] -> vertex[1], face[0] is on the left. V - E +
//      F = 2.
//   3. All arrays depend only on the points.
// A ConvexView borrows such arrays. So algorithms for polyhedra also accept a triangle or a point
// (small_pieces.h). A triangle is a polyhedron with two opposite faces.
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

/// Vertices, edges, faces and sides are counted with 16 bits: at most 6 * 1024 sides.
inline constexpr std::size_t k_hull_points_max = 1024;
/// Tolerance of the hull, as a share of its extent. Rotating and shifting a shape moves vertices by
/// some 1e-15. A larger tolerance would flatten faces by more than the error of distances.
inline constexpr double k_hull_coplanar = 1e-12;
/// If a body is thinner than this share of its extent, it is refused as flat: normals would err by
/// 1e-10.
inline constexpr double k_hull_flat = 1e-6;

/// A side of a face, from `vertex` to the next side's vertex.
struct Side {
  Vec3 inward = Vec3::Zero();  ///< unit; in the face's plane, perpendicular to the side
  double offset_m = 0;         ///< dot(inward, p) - offset_m > 0 for p on the side's inner side
  std::uint16_t vertex = 0;
  std::uint16_t edge = 0;
};

struct Face {
  Vec3 normal = Vec3::Zero();  ///< unit, outward
  double offset_m = 0;         ///< dot(normal, p) <= offset_m for the body's points p
  std::uint16_t first_side = 0;
  std::uint16_t side_count = 0;
};

struct Edge {
  std::array<std::uint16_t, 2> vertex{};
  std::array<std::uint16_t, 2> face{};
  std::array<std::uint16_t, 2> side{};  ///< this edge as a side of face[0] and of face[1]
};

class RoundPiece;

/// Borrowed arrays of a convex piece. If the piece is round, the arrays are null and only `round`
/// is set. REQUIRES: the owner stays in place while the view is used.
struct ConvexView {
  /// A round piece (round_piece.h); null for a polyhedron, a triangle or a point.
  const RoundPiece* round = nullptr;
  const Vec3* vertices_m = nullptr;
  const double* xs_m = nullptr;  ///< x of all vertices, padded with vertex 0 to a multiple of four
  const double* ys_m = nullptr;
  const double* zs_m = nullptr;
  const Face* faces = nullptr;
  const Side* sides = nullptr;
  const Edge* edges = nullptr;
  /// Vertex v has the entries ring_first[v] to ring_first[v + 1] of the three arrays below.
  const std::uint16_t* ring_first = nullptr;
  const std::uint16_t* ring_vertices = nullptr;  ///< neighbours, ascending
  const std::uint16_t* ring_edges = nullptr;     ///< edges to these neighbours
  const std::uint16_t* ring_faces = nullptr;  ///< faces at the vertex, ascending; as many as edges
  std::uint16_t vertex_count = 0;
  std::uint16_t face_count = 0;
  std::uint16_t edge_count = 0;
  std::uint16_t padded_count = 0;
  double r_outer_m = 0;          ///< distance of the furthest vertex from the frame's origin
  Vec3 centre_m = Vec3::Zero();  ///< mean of the vertices
};

class ConvexPolyhedron {
 public:
  /// A tetrahedron of size 0 at the origin, so that containers can be resized.
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
  /// Radius of a ball that contains the body. The ball's centre is the frame's origin.
  double r_outer_m() const { return r_outer_m_; }
  /// Radius of a ball that is inside the body and centred at the origin. Negative if the origin is
  /// outside the body.
  double r_inner_m() const { return r_inner_m_; }

  /// The view is valid until this polyhedron is changed, moved or destroyed.
  ConvexView view() const;

 private:
  friend ConvexPolyhedron polyhedron_of_loops(std::span<const Vec3> vertices_m,
                                              std::span<const std::vector<std::uint16_t>> loops);
  struct DirectedEdge;
  /// Adds a loop's face and its sides. The inward normals follow from the plane and the sides.
  void add_face(std::span<const std::uint16_t> loop, std::vector<DirectedEdge>& directed);
  /// Makes edges: joins each side with the opposite side of another face.
  void join_sides(std::vector<DirectedEdge>& directed);
  void index_rings();
  /// Computes the bounds and the coordinates by axis.
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

/// Returns the convex hull of points, in their frame. The time grows with points times faces: 60
/// points take some 0.1 ms, 500 points some 6 ms.
base::Result<ConvexPolyhedron, ShapeError> convex_hull(std::span<const Vec3> points_m);

/// Moves each vertex v to product(rotation, v) + shift_m. Faces and edges keep their numbers.
/// REQUIRES: rotation is orthonormal up to rounding, with determinant 1.
ConvexPolyhedron moved(const ConvexPolyhedron& polyhedron, const Mat3& rotation,
                       const Vec3& shift_m);

/// Makes a polyhedron from its vertices and one anticlockwise loop of vertices per face. Merges
/// nothing, and checks only that the arrays are consistent. REQUIRES: the loops bound a convex body
/// (for a triangle: two opposite loops).
ConvexPolyhedron polyhedron_of_loops(std::span<const Vec3> vertices_m,
                                     std::span<const std::vector<std::uint16_t>> loops);

}  // namespace sleight::physics
