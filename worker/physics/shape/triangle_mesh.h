// Static triangle meshes, and the features of theirs that a sphere can touch.
//
// Idea. A sphere's centre keeps its distance from faces, edges and vertices, each in its own
// region: above a face between its sides, beside an edge, beyond a vertex. What these tests need is
// derived once. Edges where the surface is flat or hollow, and vertices with such edges alone, can
// never be touched first, so they are marked. A world that draws its geometry anew may move
// vertices: only what hangs on them is derived again.
//
// Invariants
//   1. A mesh has passed all checks: finite vertices, no triangle thinner than k_mesh_sliver, every
//      edge in at most two triangles, which run it in opposite directions (so that the outside is
//      the same side for neighbours), and in exactly two if a closed mesh was asked for.
//   2. Derived data are a function of vertices and triangles alone: after move_vertices they equal
//   a
//      fresh build's bit for bit. Numbers and topology never change.
//   3. Edges are in ascending order of (lower, higher vertex). A failed move changes nothing.
// Thread safety: const access from several threads; moving vertices excludes all else.
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

/// Triangles whose height is below this part of their longest side are refused: their normals would
/// carry rounding errors of 1e-10.
inline constexpr double k_mesh_sliver = 1e-6;
/// Triangles whose longest side is no longer than this are refused: its square would be no number
/// to divide by.
inline constexpr double k_mesh_point_m = 1e-60;
/// Sine of the angle below which two faces count as one plane, to rounding.
inline constexpr double k_mesh_flat_sine = 1e-12;
inline constexpr std::uint32_t k_no_triangle = std::numeric_limits<std::uint32_t>::max();

/// Corners anticlockwise seen from outside.
using TriangleCorners = std::array<std::uint32_t, 3>;

struct MeshError {
  enum class Kind : std::uint8_t {
    vertex_not_finite,     ///< `triangle`: the first that uses it, or k_no_triangle
    index_out_of_range,    ///< of `vertex`
    degenerate_triangle,   ///< thinner than k_mesh_sliver, or the same corner twice
    edge_shared_by_three,  ///< `other`: another triangle at the same edge
    edge_run_twice,        ///< `other` runs an edge in the same direction: one is inside out
    not_closed             ///< an edge of `triangle` has no other one
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
  double offset_m = 0;         ///< dot(normal, p) = offset_m in the plane
  /// Of the side from corner k to k + 1: unit, in the plane, inward. A point is above the face if
  /// dot(inward[k], p) >= inward_offset_m[k] for all k.
  std::array<Vec3, 3> inward{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::array<double, 3> inward_offset_m{};
  friend bool operator==(const MeshFace&, const MeshFace&) = default;
};

enum class EdgeKind : std::uint8_t { convex, flat, concave, boundary };

struct MeshEdge {
  std::array<std::uint32_t, 2> vertex{};  ///< run this way by triangle[0], which lies on the left
  std::array<std::uint32_t, 2> triangle{k_no_triangle, k_no_triangle};  ///< [1] none at a boundary
  Vec3 start_m = Vec3::Zero();
  Vec3 direction = Vec3::Zero();  ///< unit, from vertex[0] to vertex[1]
  double length_m = 0;
  std::array<Vec3, 2> normal{Vec3::Zero(), Vec3::Zero()};  ///< of triangle[0] and [1], or zero
  EdgeKind kind = EdgeKind::flat;
  std::array<std::uint8_t, 2> side{};  ///< which of triangle[0]'s and [1]'s it is
  friend bool operator==(const MeshEdge&, const MeshEdge&) = default;
};

enum class MeshClosure : std::uint8_t { may_be_open, closed };

struct VertexMove {
  std::uint32_t vertex = 0;
  Vec3 position_m = Vec3::Zero();
};

class TriangleMesh {
 public:
  /// Checks and derives. Vertices that no triangle uses are allowed.
  static base::Result<TriangleMesh, MeshError> make(std::span<const Vec3> vertices_m,
                                                    std::span<const TriangleCorners> triangles,
                                                    MeshClosure closure);

  std::span<const Vec3> vertices_m() const { return vertices_m_; }
  std::span<const TriangleCorners> triangles() const { return triangles_; }
  std::span<const MeshFace> faces() const { return faces_; }  ///< one for each triangle
  std::span<const MeshEdge> edges() const { return edges_; }
  /// Whether a convex or boundary edge meets at a vertex: only such vertices can be touched first.
  bool exposed(std::uint32_t vertex) const { return exposing_edges_[vertex] != 0; }
  /// The edges of triangle t: number k joins its corners k and k + 1.
  const std::array<std::uint32_t, 3>& edges_of(std::uint32_t triangle) const {
    return triangle_edges_[triangle];
  }

  /// The edges that end at a vertex, ascending.
  std::span<const std::uint32_t> edges_at(std::uint32_t vertex) const {
    return std::span(edges_about_)
        .subspan(edges_first_[vertex],
                 edges_first_[vertex + std::size_t{1}] - edges_first_[vertex]);
  }

  /// Puts vertices elsewhere, the last one given counting if a vertex comes twice, and derives
  /// again what hangs on them: some 0.1 us for each triangle about, less if the same vertices moved
  /// the last time. No allocation once the largest set of vertices has been moved. On an error, of
  /// the lowest triangle concerned, nothing changes. REQUIRES: the vertices exist.
  [[nodiscard]] std::optional<MeshError> move_vertices(std::span<const VertexMove> moves);
  /// The triangles that the last move changed, their edges, and the ends of these: in no particular
  /// order, each once.
  std::span<const std::uint32_t> moved_triangles() const { return moved_triangles_; }
  std::span<const std::uint32_t> moved_edges() const { return moved_edges_; }
  std::span<const std::uint32_t> moved_vertices() const { return moved_vertices_; }
  /// Those of the moved edges that have become flat, or are flat no more.
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
  std::vector<std::uint32_t> exposing_edges_;  ///< by vertex: how many
  std::vector<std::array<std::uint32_t, 3>> triangle_edges_;
  // Of vertex v, the entries first[v] to first[v + 1].
  std::vector<std::uint32_t> triangles_first_, triangles_about_;
  std::vector<std::uint32_t> edges_first_, edges_about_;
  // What the last move changed; of which vertices, as they were given.
  std::vector<std::uint32_t> moves_of_;
  std::vector<std::uint32_t> moved_triangles_, moved_edges_, moved_vertices_, flat_changes_;
  // Room for move_vertices.
  std::vector<Vec3> old_positions_m_;
  std::vector<std::uint8_t> is_moved_;  ///< all 0 between uses
};

}  // namespace sleight::physics
