// Static triangle meshes, and their features that a sphere can touch.
//
// Idea. A sphere's centre keeps its distance from faces, edges and vertices. A face's region is
// above the face and between its sides. An edge's region is beside the edge, a vertex's region
// beyond the vertex. The data that describe these regions are derived once. Where the surface is
// flat or concave, an edge can never be touched first, so it is marked. A vertex is marked too if
// it has only such edges. If a world draws its geometry again, it may move vertices. Then only data
// that depend on these vertices are derived again.
//
// Invariants
//   1. A mesh has passed all checks. All vertices are finite, and no triangle is thinner than
//      k_mesh_sliver. Every edge is in at most two triangles. Two triangles at an edge list its
//      vertices in opposite orders, so neighbours have the same outside. In a closed mesh, every
//      edge is in exactly two triangles.
//   2. Derived data depend only on vertices and triangles: after move_vertices() they equal the
//      data of a fresh build, bit for bit. The numbering of features and the topology never change.
//   3. Edges are in ascending order of (lower, higher vertex). A failed move changes nothing.
// Thread safety: const functions may be called from several threads, but not while a thread moves
// vertices.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/math/vector.h"

namespace sleight::physics {

using math::Vec3;

/// Triangles thinner than this share of their longest side are refused, because their normals would
/// have rounding errors of 1e-10.
inline constexpr double k_mesh_sliver = 1e-6;
/// Triangles whose longest side is at most this are refused: division by its square would be
/// unsafe.
inline constexpr double k_mesh_point_m = 1e-60;
/// If the sine of the angle between two faces is smaller than this, they count as one plane.
inline constexpr double k_mesh_flat_sine = 1e-12;
inline constexpr std::uint32_t k_no_triangle = std::numeric_limits<std::uint32_t>::max();

/// Corners anticlockwise seen from outside.
using TriangleCorners = std::array<std::uint32_t, 3>;

struct MeshError {
  enum class Kind : std::uint8_t {
    vertex_not_finite,     ///< the first triangle that uses it is `triangle`, or k_no_triangle
    index_out_of_range,    ///< the index is that of `vertex`
    degenerate_triangle,   ///< thinner than k_mesh_sliver, or the same corner twice
    edge_shared_by_three,  ///< a third triangle at the edge is `other`
    /// `other` has an edge of `triangle` in the same direction, so one of the two is inside out.
    edge_run_twice,
    not_closed  ///< an edge of `triangle` has no second triangle
  };
  Kind kind{};
  std::uint32_t triangle = k_no_triangle;
  std::uint32_t other = k_no_triangle;
  std::uint32_t vertex = 0;
  friend bool operator==(const MeshError&, const MeshError&) = default;
};

/// A sentence for people, without a full stop.
std::string describe(const MeshError& error);

struct MeshFace {
  Vec3 normal = Vec3::Zero();  ///< unit, outward
  double offset_m = 0;         ///< dot(normal, p) = offset_m for p in the plane
  /// inward[k] belongs to the side from corner k to k + 1. The vector has length 1, is in the
  /// face's plane, and points inwards. A point is above the face if dot(inward[k], p) >=
  /// inward_offset_m[k] for all k.
  std::array<Vec3, 3> inward{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::array<double, 3> inward_offset_m{};
  friend bool operator==(const MeshFace&, const MeshFace&) = default;
};

enum class EdgeKind : std::uint8_t { convex, flat, concave, boundary };

struct MeshEdge {
  /// The edge's ends. Seen along vertex[0] -> vertex[1], triangle[0] is on the left.
  std::array<std::uint32_t, 2> vertex{};
  /// [1] is k_no_triangle at a boundary.
  std::array<std::uint32_t, 2> triangle{k_no_triangle, k_no_triangle};
  Vec3 start_m = Vec3::Zero();
  Vec3 direction = Vec3::Zero();  ///< unit, from vertex[0] to vertex[1]
  double length_m = 0;
  /// Normals of triangle[0] and triangle[1]. Zero if there is no second triangle.
  std::array<Vec3, 2> normal{Vec3::Zero(), Vec3::Zero()};
  EdgeKind kind = EdgeKind::flat;
  std::array<std::uint8_t, 2> side{};  ///< the edge's number among the sides of triangle[0] and [1]
  friend bool operator==(const MeshEdge&, const MeshEdge&) = default;
};

enum class MeshClosure : std::uint8_t { may_be_open, closed };

struct VertexMove {
  std::uint32_t vertex = 0;
  Vec3 position_m = Vec3::Zero();
};

class TriangleMesh {
 public:
  /// Checks the input and derives all data. Permits unused vertices.
  static base::Result<TriangleMesh, MeshError> make(std::span<const Vec3> vertices_m,
                                                    std::span<const TriangleCorners> triangles,
                                                    MeshClosure closure);

  std::span<const Vec3> vertices_m() const { return vertices_m_; }
  std::span<const TriangleCorners> triangles() const { return triangles_; }
  std::span<const MeshFace> faces() const { return faces_; }  ///< one for each triangle
  std::span<const MeshEdge> edges() const { return edges_; }
  /// Returns whether a vertex has a convex or boundary edge. Other vertices can't be touched first.
  bool exposed(std::uint32_t vertex) const { return exposing_edges_[vertex] != 0; }
  /// Returns a triangle's edges: edge k joins its corners k and k + 1.
  const std::array<std::uint32_t, 3>& edges_of(std::uint32_t triangle) const {
    return triangle_edges_[triangle];
  }

  /// Returns the edges that end at a vertex, ascending.
  std::span<const std::uint32_t> edges_at(std::uint32_t vertex) const {
    return std::span(edges_about_)
        .subspan(edges_first_[vertex],
                 edges_first_[vertex + std::size_t{1}] - edges_first_[vertex]);
  }

  /// Moves vertices and derives the dependent data again. Takes some 0.1 us per adjacent triangle,
  /// or less if the last move had the same vertices. If a vertex occurs twice, the last move
  /// counts. Doesn't allocate after the largest set of vertices has been moved once. On an error
  /// nothing changes. The error names the invalid triangle with the lowest index. REQUIRES: the
  /// vertices exist.
  [[nodiscard]] std::optional<MeshError> move_vertices(std::span<const VertexMove> moves);
  /// The triangles that the last move changed, these triangles' edges, and the edges' ends. Each
  /// item is listed once, in no order.
  std::span<const std::uint32_t> moved_triangles() const { return moved_triangles_; }
  std::span<const std::uint32_t> moved_edges() const { return moved_edges_; }
  std::span<const std::uint32_t> moved_vertices() const { return moved_vertices_; }
  /// Moved edges that became flat, or stopped being flat.
  std::span<const std::uint32_t> flat_changes() const { return flat_changes_; }

 private:
  TriangleMesh() = default;
  std::optional<MeshError> check_triangle(std::uint32_t triangle) const;
  void index_vertices();
  void find_moved(std::span<const VertexMove> moves);
  MeshError error_of_move(std::span<const VertexMove> moves) const;
  bool derive_faces(std::span<const std::uint32_t> triangles);
  void derive_edges(std::span<const std::uint32_t> edges);
  void count_edge(const MeshEdge& edge, EdgeKind before);

  std::vector<Vec3> vertices_m_;
  std::vector<TriangleCorners> triangles_;
  std::vector<MeshFace> faces_;
  std::vector<MeshEdge> edges_;
  std::vector<std::uint32_t> exposing_edges_;  ///< number of such edges by vertex
  std::vector<std::array<std::uint32_t, 3>> triangle_edges_;
  // Vertex v has the entries first[v] to first[v + 1].
  std::vector<std::uint32_t> triangles_first_, triangles_about_;
  std::vector<std::uint32_t> edges_first_, edges_about_;
  // Vertices of the last move, in the given order, and what that move changed.
  std::vector<std::uint32_t> moves_of_;
  std::vector<std::uint32_t> moved_triangles_, moved_edges_, moved_vertices_, flat_changes_;
  // Scratch memory of move_vertices.
  std::vector<Vec3> old_positions_m_;
  std::vector<std::uint8_t> is_moved_;  ///< all 0 between calls
};

}  // namespace sleight::physics
